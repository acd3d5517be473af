// import, columns and indices of mmg-sim.

#include <filesystem>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "io/json.hpp"
#include "run.hpp"

using namespace leeway;
using Catch::Matchers::Contains;

namespace {

// t, speed in knots, sway, heading and yaw rate, by semicolons, over a minute.
std::string raw_log() {
  std::string text = "Log of a trip\nt;sog;v;hdg;rot\n";
  for (int i = 0; i < 60; ++i) text += fmt::format("{};2,5;0,1;{},5;6\n", i, i % 10);
  return text;
}
constexpr const char* kMap = R"({"t_s": "t", "u_mps": {"from": "sog", "unit": "kn"}, "vm_mps": "v", "psi_deg": "hdg",
  "r_degps": {"derive": "psi_deg"}, "file": {"delimiter": ";", "decimal": ",", "skip_lines": 1}})";

}  // namespace

TEST_CASE("mmg-sim import writes leeway's form, one file or a folder with an index", "[cli]") {
  const test::TemporaryFolder folder;
  folder.write("a.txt", raw_log());
  folder.write("b.txt", raw_log());
  folder.write("map.json", kMap);
  const test::Outcome one = test::run(folder, "mmg-sim import a.txt --columns map.json");
  CHECK(one.exit_code == 0);
  CHECK_THAT(one.out, Catch::Matchers::StartsWith("t_s,u_mps,vm_mps,r_degps,psi_deg,r_derived\n0,1.286"));
  CHECK_THAT(one.err, Contains("r_degps of 1 of 1 recordings is derived from psi_deg, not measured"));

  REQUIRE(test::run(folder, "mmg-sim import a.txt b.txt --columns map.json -o read").exit_code == 0);
  const io::Json index = io::read_json(folder / "read/dataset.json");
  CHECK(index["sets"][0]["recordings"].size() == 2);
  CHECK(index["provenance"]["inputs"].size() == 3);
  CHECK(index["parts"].contains("b.csv"));
  CHECK(io::read_text(folder / "read/b.csv") == one.out);
  // Other tools know the derived channel as derived.
  const test::Outcome other = test::run(folder, "mmg-sim indices read/dataset.json");
  CHECK(other.exit_code == 0);
  CHECK_THAT(other.err, Contains("r_degps of 2 of 2 recordings is derived"));

  CHECK(test::run(folder, "mmg-sim import a.txt --columns map.json -o a.txt").exit_code == 2);
  CHECK(test::run(folder, "mmg-sim import a.txt b.txt --columns map.json -o -").exit_code == 2);
  CHECK(test::run(folder, "mmg-sim import a.txt").exit_code == 2);
  CHECK(test::run(folder, "mmg-sim import none.txt --columns map.json").exit_code == 4);
  folder.write("bad.txt", "x\nt;sog;v;hdg;rot\n5;1;0;0;0\n4;1;0;0;0\n");
  const test::Outcome bad = test::run(folder, "mmg-sim import bad.txt --columns map.json");
  CHECK(bad.exit_code == 3);
  CHECK(bad.out.empty());
  CHECK_THAT(bad.err, Contains("bad.txt:4: column 't': time must increase, but 4 s follows 5 s"));
}

TEST_CASE("mmg-sim columns proposes a map that import takes, and says what it does not know", "[cli]") {
  const test::TemporaryFolder folder;
  const std::string pipeline =
      "mmg-sim zigzag --ship kvlcc2-l7 --sample-s 0.5 --duration-s 100 -o z.csv && "
      "mmg-sim columns z.csv > map.json && mmg-sim import z.csv --columns ./map.json -o again.csv";
  const test::Outcome done = test::run(folder, pipeline);
  CHECK(done.exit_code == 0);
  CHECK_THAT(done.err, Contains("midship is assumed"));
  CHECK_THAT(io::read_text(folder / "again.csv"), Catch::Matchers::StartsWith("t_s,u_mps,vm_mps,r_degps,"));
  folder.write("words.txt", "a b\nc d\n");
  CHECK(test::run(folder, "mmg-sim columns words.txt").exit_code == 3);
}

TEST_CASE("mmg-sim indices reads a turning circle and a zigzag off simulated recordings", "[cli]") {
  const test::TemporaryFolder folder;
  REQUIRE(test::run(folder,
                    "mmg-sim turning --ship kvlcc2-full --duration-s 1500 -o turn.csv && "
                    "mmg-sim zigzag --ship kvlcc2-full --duration-s 800 -o zigzag.csv")
              .exit_code == 0);
  const test::Outcome text = test::run(folder, "mmg-sim indices turn.csv zigzag.csv --length-m 320");
  CHECK(text.exit_code == 0);
  CHECK_THAT(text.out, Contains("turn: turning, 35 deg to starboard") && Contains("zigzag: zigzag 10/10 to starboard"));
  CHECK_THAT(text.out, Contains("IMO advance") && Contains("IMO first_overshoot_10_10"));
  const test::Outcome json = test::run(folder, "mmg-sim indices turn.csv --ship kvlcc2-full --json -o i.json");
  CHECK(json.exit_code == 0);
  const io::Json indices = io::read_json(folder / "i.json");
  CHECK(indices["ship"]["name"] == "kvlcc2-full");
  CHECK(indices["recordings"][0]["indices"]["advance_over_L"].is_number());
  CHECK(indices["provenance"]["tool"] == "mmg-sim");
  CHECK_THAT(test::run(folder, "mmg-sim indices turn.csv").out, !Contains(" L\n"));
  CHECK(test::run(folder, "mmg-sim indices turn.csv --ship kvlcc2-full --length-m 320").exit_code == 2);
}

TEST_CASE("columns maps: a column that is named and not there is told where others are ignored", "[cli]") {
  const test::TemporaryFolder folder;
  folder.write("map.json", R"({"psi_deg": "heading"})");
  folder.write("typo.csv", "t_s,u_mps,vm_mps,r_degps,hdg\n0,1,0,0,5\n1,1,0,0,5\n");
  const test::Outcome typo = test::run(folder, "mmg-sim import typo.csv --columns ./map.json -o -");
  CHECK(typo.exit_code == 0);
  CHECK_THAT(typo.err, Contains("are ignored: hdg; the columns map names columns that are not there: heading"));
  // Leeway's own name is there.
  folder.write("own.csv", "t_s,u_mps,vm_mps,r_degps,psi_deg\n0,1,0,0,5\n1,1,0,0,5\n");
  const test::Outcome own = test::run(folder, "mmg-sim import own.csv --columns ./map.json -o -");
  CHECK(own.err.empty());
  CHECK_THAT(own.out, Contains("psi_deg") && Contains(",5"));
}

TEST_CASE("mmg-sim says that a wind without a speed is none", "[cli]") {
  const test::TemporaryFolder folder;
  const test::Outcome outcome =
      test::run(folder, "mmg-sim turning --ship esso-osaka-3m --wind-dir-deg 90 --duration-s 20 -o t.csv");
  CHECK(outcome.exit_code == 0);
  CHECK_THAT(outcome.err, Contains("there is no wind: its speed (--wind-speed-mps) is 0"));
}
