// CSV files that are written with -o FILE have their provenance beside them.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "ensemble.hpp"
#include "io/json.hpp"

using namespace leeway;
using namespace test;

namespace {

io::Json beside(const TemporaryFolder& folder, const std::string& csv) {
  const io::Json json = io::read_json(folder / (csv + ".provenance.json"));
  CHECK(json["sha256"] == io::sha256_of_file(folder / csv));
  return json["provenance"];
}

}  // namespace

TEST_CASE("provenance: a simulation has it beside its CSV files, a stream has none", "[cli][provenance]") {
  const TemporaryFolder folder;
  const std::string random = "mmg-sim random --ship vectwin-3m --duration-s 10 --seed 7 --noise paper-model-scale ";
  done(folder, random + "-o r.csv --truth t.csv");
  CHECK(folder.listing() == "r.csv r.csv.provenance.json t.csv t.csv.provenance.json");
  const io::Json made_by = beside(folder, "r.csv");
  CHECK(made_by == beside(folder, "t.csv"));
  CHECK(made_by["tool"] == "mmg-sim");
  CHECK(made_by["version"] == LEEWAY_VERSION);
  CHECK(made_by["seed"] == 7);
  CHECK(made_by["command"][1] == "--seed");
  CHECK(made_by["inputs"][0]["file"] == "configs/ships/vectwin-3m.json");
  CHECK(made_by["inputs"][1]["file"] == "configs/noise/paper-model-scale.json");
  CHECK(made_by["inputs"][0]["sha256"].get<std::string>().size() == 64);
  // Equal results are equal files.
  done(folder, random + "-o again.csv --truth t.csv --jobs 1");
  CHECK(io::read_text(folder / "again.csv.provenance.json") == io::read_text(folder / "r.csv.provenance.json"));

  const TemporaryFolder streams;
  done(streams, random + "-o -");
  done(streams, random + "-o /dev/null");
  CHECK(streams.listing().empty());
}

TEST_CASE("provenance: replays, imports, sweeps and steps have it as well", "[cli][provenance]") {
  const TemporaryFolder folder;
  prepare_model(folder);
  done(folder, "mmg-sim replay --ship vectwin-3m data/test/test-r-01.csv -o replayed.csv");
  const io::Json replayed = beside(folder, "replayed.csv");
  CHECK(replayed["inputs"][1]["file"] == "data/test/test-r-01.csv");
  CHECK(replayed["ship"]["name"] == "vectwin-3m");
  folder.write("map.json", R"({"t_s": "t"})");
  folder.write("raw.txt", "t,u_mps,vm_mps,r_degps\n0,1,0,0\n1,1,0,0\n");
  done(folder, "mmg-sim import raw.txt --columns map.json -o imported.csv");
  CHECK(beside(folder, "imported.csv")["inputs"].size() == 2);
  done(folder, "pd-sweep model --ship vectwin-3m --kp 40 --kd 60 --duration-s 20 --quiet -o sweep.csv");
  CHECK(beside(folder, "sweep.csv")["ship"]["name"] == "vectwin-3m");
  done(folder,
       "ens-predict model 'data/dataset.json#test' --quiet | eval-metrics - --truth data/dataset.json --quiet "
       "--per-step steps.csv -o metrics.json");
  CHECK(beside(folder, "steps.csv") == io::read_json(folder / "metrics.json")["provenance"]);
  // What an input is called is no output: neither the file nor what would lie beside it.
  folder.write("z.csv.provenance.json", "[]");
  check_refused(folder, "mmg-sim zigzag --ship vectwin-3m --effect z.csv.provenance.json -o z.csv", 2,
                "z.csv.provenance.json");
}
