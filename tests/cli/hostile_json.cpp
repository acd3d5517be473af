// JSON that is made to break a reader: every kind of JSON file, by a tool that reads it.

#include <catch2/catch.hpp>

#include "ensemble.hpp"

using namespace leeway;
using namespace test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

struct JsonReader {
  std::string file, command;
};

const std::vector<JsonReader> kJsonReaders{
    {"map.json", "ens-predict --baseline hold rec.csv --steps 2 --columns map.json -o -"},
    {"dataset.json", "ens-predict --baseline hold dataset.json --steps 2 -o -"},
    {"ship.json", "mmg-sim zigzag --ship ship.json -o -"},
    {"ship.json", "gap-locate --ship ship.json rec.csv -o out"},
    {"ship.json", "gap-explain --ship ship.json rec.csv -o out"},
    {"ship.json", "ens-train data/dataset.json#train --config tiny.json --base ship.json -o out"},
    {"effect.json", "mmg-sim zigzag --ship kvlcc2-l7 --effect effect.json -o -"},
    {"noise.json", "mmg-sim zigzag --ship kvlcc2-l7 --noise noise.json --duration-s 2 -o -"},
    {"spec.json", "mmg-sim dataset spec.json -o out"},
    {"config.json", "ens-train data/dataset.json#train --config config.json -o out"},
    {"model/ensemble.json", "ens-predict model data/dataset.json#test --steps 10 -o -"},
    {"model/member-01.json", "ens-predict model data/dataset.json#test --steps 10 -o -"},
    {"predicted/prediction.json", "eval-metrics predicted --truth data/dataset.json#test -o -"},
};

struct HostileText {
  std::string name, text, message;  ///< from the file's name on
};

std::vector<HostileText> hostile_texts() {
  return {{"nested", "{\"a\":" + std::string(100'000, '[') + std::string(100'000, ']') + "}",
           ":1:105: objects and arrays are nested more than 100 deep"},
          {"nested without end", "{\"a\":" + std::string(100'000, '['), ":1:105: objects and arrays are nested"},
          {"NUL", std::string("{\n}\n\0 more", 10), ":3:1: not valid JSON: a NUL byte"},
          {"twice", "{\"a\": {\"b\": 1,\n \"b\": 2}}", ":2:2: /a/b: the key stands twice in one object"},
          {"overflow", "{\"a\": [1,\n -1e999]}", ":2:7: /a/1: the number is too large"},
          {"top level", "\n 17\n", ":2:2: expected an object"},
          {"nested at the top", std::string(100'000, '[') + std::string(100'000, ']'),
           ":1:101: objects and arrays are nested more than 100 deep"}};
}

}  // namespace

TEST_CASE("errors: names in a data set's specification that are not shipped are wrong contents of a file",
          "[cli][errors]") {
  const TemporaryFolder folder;
  folder.write("spec.json", R"({"ship": "kvlcc3", "sets": []})");
  check_refused(folder, "mmg-sim dataset spec.json -o out", 3, "spec.json: /ship: no file 'kvlcc3', and no shipped");
  folder.write("spec.json", R"({"ship": "vectwin-3m", "noise": "none", "sets": []})");
  check_refused(folder, "mmg-sim dataset spec.json -o out", 3, "spec.json: /noise: no file 'none', and no shipped");
}

TEST_CASE("errors: a key of prediction.json that nobody knows is refused", "[cli][errors]") {
  const TemporaryFolder folder;
  folder.write("rec.csv", "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n");
  done(folder, "ens-predict --baseline hold rec.csv --steps 2 -o predicted");
  replace(folder / "predicted/prediction.json", "\"sampling\"", "\"smapling\"");
  check_refused(folder, "eval-metrics predicted --truth rec.csv -o -", 3,
                "predicted/prediction.json: /smapling: unknown key");
}

TEST_CASE("errors: JSON that nests without end, repeats, overflows or is no object names file, line and pointer",
          "[cli][errors]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  done(folder, "ens-predict model data/dataset.json#test --steps 10 --particles 4 --quiet -o predicted");
  folder.write("rec.csv", "t_s,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n");
  for (const JsonReader& reader : kJsonReaders) {
    const bool replaces = fs::exists(folder / reader.file);
    const std::string good = replaces ? io::read_text(folder / reader.file) : "";
    for (const HostileText& hostile : hostile_texts()) {
      CAPTURE(reader.command, hostile.name);
      folder.write(reader.file, hostile.text);
      check_refused(folder, reader.command, 3, reader.file + hostile.message);
    }
    if (replaces) folder.write(reader.file, good);
    CHECK_FALSE(fs::exists(folder / "out"));
  }
}
