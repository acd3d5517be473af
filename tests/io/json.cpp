#include "io/json.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "io/dataset_json.hpp"
#include "io/json_check.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;

namespace {

const char* kShip = R"({
  "name": "barge", "count": 3, "flag": true, "list": [1, 2, "x"],
  "hull": {"L_pp_m": -7, "d_m": 0.5, "terms": [{"Y_v": 1}, 5]}
})";

template <typename Ask>
void refused(const Ask& ask, const std::string& because) {
  const io::Json json = io::parse_json(kShip, "ship.json");
  const io::JsonObject ship(json, "ship.json");
  CHECK_THROWS_AS(ask(ship), InputError);
  CHECK_THROWS_WITH(ask(ship), Contains(because));
}

}  // namespace

TEST_CASE("json: a wrong value is named with its pointer, what was expected and what was found", "[io][json]") {
  using O = const io::JsonObject&;
  refused([](O s) { s.object("hull").number("L_pp_m", io::kPositive); },
          "ship.json: /hull/L_pp_m: expected a number > 0, got -7");
  refused([](O s) { s.object("hull").number("d_m", {1.0, 2.0}); }, "/hull/d_m: expected a number from 1 to 2, got 0.5");
  refused([](O s) { s.object("hull").integer("d_m"); }, "/hull/d_m: expected a whole number, got 0.5");
  refused([](O s) { s.number("name"); }, "/name: expected a number, got \"barge\"");
  refused([](O s) { s.text("count"); }, "/count: expected a text, got 3");
  refused([](O s) { s.flag_or("count", false); }, "/count: expected true or false, got 3");
  refused([](O s) { s.word("name", {"ship", "boat"}); }, "/name: unknown 'barge'; known: ship, boat");
  refused([](O s) { s.numbers("list"); }, "/list/2: expected a number, got \"x\"");
  refused([](O s) { s.texts("list"); }, "/list/0: expected a text, got 1");
  refused([](O s) { s.numbers("hull"); }, "/hull: expected an array of numbers");
  refused([](O s) { s.object("name"); }, "/name: expected an object");
  refused([](O s) { s.object("hull").objects("terms"); }, "/hull/terms/1: expected an object, got 5");
}

TEST_CASE("json: a key that nobody asked for is an error, and a missing one names its neighbors", "[io][json]") {
  const io::Json json = io::parse_json(R"({"Y_vvr": 1, "Y_v": 2})", "hull.json");
  {
    const io::JsonObject hull(json, "hull.json");
    CHECK(hull.number("Y_v") == 2.0);
    CHECK(hull.number_or("Y_vrr", 0.0) == 0.0);
    CHECK_THROWS_WITH(hull.check_all_known(), Contains("hull.json: /Y_vvr: unknown key; known here: Y_v, Y_vrr"));
    CHECK(hull.number("Y_vvr") == 1.0);
    CHECK_NOTHROW(hull.check_all_known());
  }
  const io::JsonObject hull(json, "hull.json");
  CHECK_THROWS_WITH(hull.number("Y_vv"), Contains("/Y_vv: missing, expected a number") && Contains("Y_vvr"));
}

TEST_CASE("json: bad syntax is named with line and column as an editor counts them", "[io][json]") {
  CHECK_THROWS_WITH(io::parse_json("{\n  \"a\": 1,\n  \"b\": }\n", "x.json"), Contains("x.json:3:8: not valid JSON"));
  CHECK_THROWS_WITH(io::parse_json("{]", "x.json"), Contains("x.json:1:2: not valid JSON"));
  CHECK_THROWS_WITH(io::parse_json("{\"a\": 1", "x.json"), Contains("x.json:1:8: not valid JSON"));
  CHECK_THROWS_WITH(io::parse_json(" \n", "x.json"), Contains("the file is empty"));
  CHECK_THROWS_WITH(io::parse_json("{\"a\": nan}", "x.json"), Contains("not valid JSON"));
  CHECK_THROWS_WITH(
      io::parse_json("{\"a\": 1e999}", "x.json"),
      Contains("x.json:1:") && Contains(": /a: the number is too large: number overflow parsing '1e999'"));
}

TEST_CASE("json: a key that stands twice in one object is refused, in two objects it is not", "[io][json]") {
  CHECK_THROWS_WITH(io::parse_json(R"({"a": {"k": 1, "b": 2, "k": 3}})", "x.json"),
                    Contains("x.json:1:24: /a/k: the key stands twice"));
  CHECK_THROWS_WITH(io::parse_json("{\"a\": [0, {\"q\\\"\": 1,\n  \"q\\\"\": 2}]}", "x.json"),
                    Contains("x.json:2:3: /a/1/q\": the key stands twice"));
  CHECK_NOTHROW(io::parse_json(R"({"k": {"k": [{"k": 1}, {"k": 2}]}, "a": {"k": 1}})", "x.json"));
}

TEST_CASE("json: what values would hide or break on is named with its place", "[io][json]") {
  const auto refused = [](const std::string& text, const std::string& because) {
    CHECK_THROWS_AS(io::parse_json(text, "x.json"), InputError);
    CHECK_THROWS_WITH(io::parse_json(text, "x.json"), Contains(because));
  };
  refused(std::string("{}\n\0{", 5), "x.json:2:1: not valid JSON: a NUL byte");
  refused("{\"list\": [1,\n 2, 1e400]}", "x.json:2:");
  refused("{\"list\": [1,\n 2, 1e400]}", ": /list/2: the number is too large");
  refused("\n\n  [1]", "x.json:3:3: expected an object, got [1]");
  refused("7\n", "x.json:1:1: expected an object, got 7");
  CHECK_NOTHROW(io::parse_json("[{}]", "x.json", io::JsonTop::object_or_array));
  CHECK_THROWS_WITH(io::parse_json("\"text\"", "x.json", io::JsonTop::object_or_array),
                    Contains("x.json:1:1: expected an object or an array of objects, got \"text\""));

  const auto nested = [](std::size_t depth) {
    return "{\"a\":\n" + std::string(depth - 1, '[') + std::string(depth - 1, ']') + "}";
  };
  CHECK_NOTHROW(io::parse_json(nested(io::kDeepestJson), "x.json"));
  refused(nested(io::kDeepestJson + 1), "x.json:2:100: objects and arrays are nested more than 100 deep");
  refused(nested(1'000'000), "x.json:2:100: objects and arrays are nested more than 100 deep");
  refused("{\"a\":" + std::string(1'000'000, '['), "nested more than 100 deep");
  std::string binary(1'000'000, '\x81');  // CBOR: arrays of one within each other
  CHECK_THROWS_WITH(io::check_cbor<io::Json>(binary, "x"), Contains("nested more than 100 deep"));
}

TEST_CASE("json: a whole number beyond those of the processor is refused, not wrapped", "[io][json]") {
  const io::Json json = io::parse_json(R"({"n": 9223372036854775807, "too": 9223372036854775808})", "x.json");
  const io::JsonObject object(json, "x.json");
  CHECK(object.integer("n") == 9223372036854775807L);
  CHECK_THROWS_WITH(object.integer("too"), Contains("/too: expected a whole number, got 9223372036854775808"));
}

TEST_CASE("json: numbers are written so that they read back to the same bits", "[io][json]") {
  for (const double x : {0.1, 1.0 / 3.0, 1e-300, -123456.789, 5e-324})
    CHECK(io::parse_json(io::to_text({{"x", x}}), "x.json")["x"].get<double>() == x);
}

TEST_CASE("json: a name that is not UTF-8 is written with replacement characters", "[io][json]") {
  CHECK(io::to_text({{"file", "caf\xE9.csv"}}) == "{\n  \"file\": \"caf\xEF\xBF\xBD.csv\"\n}\n");
}

TEST_CASE("dataset: a file expands to its recordings, one set or all", "[io][dataset]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.write("data/dataset.json", R"({"noise": {"u_mps": 0.01}, "sets": [
    {"name": "train", "recordings": [{"file": "train/a.csv", "truth": "train/truth/a.csv"}, {"file": "train/b.csv"}]},
    {"name": "test", "recordings": [{"file": "test/c.csv"}]}]})");
  const auto all = io::expand_recordings({path, folder / "more/d.csv"});
  REQUIRE(all.size() == 4);
  CHECK(all[0].path == folder / "data/train/a.csv");
  CHECK(all[0].truth == folder / "data/train/truth/a.csv");
  CHECK(all[0].set == "train");
  CHECK(all[1].truth.empty());
  CHECK(all[2].set == "test");
  CHECK(all[3].set == "more");
  CHECK(io::expand_recordings({path + "#test"}).size() == 1);
  CHECK(io::set_of_path(folder / "more/truth/d.csv") == "more");
  CHECK_THROWS_WITH(io::expand_recordings({path + "#tset"}), Contains("no set 'tset'; sets: train, test"));
  const auto refused = [&](const std::string& text, const std::string& because) {
    CHECK_THROWS_WITH(io::expand_recordings({folder.write("bad.json", text)}), Contains(because));
  };
  refused(R"({"sets": []})", "lists no recording");
  refused(R"({"sest": []})", "/sets: missing, expected an array of objects; not yet read here: sest");
  refused(R"({"sets": [{"name": "a", "recordings": [{"file": "a.csv", "truht": "t.csv"}]}]})",
          "/sets/0/recordings/0/truht: unknown key");
  refused(R"({"sets": [{"name": "a", "recordings": [{"file": 3}]}]})", "/sets/0/recordings/0/file: expected a text");
}
