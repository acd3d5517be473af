// mmg-sim estimate and scale, and what their ships say to the other tools.
#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/run.hpp"
#include "io/json.hpp"

using Catch::Matchers::Contains;
using leeway::io::Json;
using leeway::io::read_json;
using leeway::test::Outcome;
using leeway::test::run;
using leeway::test::TemporaryFolder;

namespace {

void done_quietly(const TemporaryFolder& folder, const std::string& command) {
  const Outcome result = run(folder, command);
  CAPTURE(command, result.err);
  REQUIRE(result.exit_code == 0);
}

void answers(const TemporaryFolder& folder, const std::string& command, int code, const std::string& message) {
  const Outcome result = run(folder, command);
  CAPTURE(command, result.err);
  CHECK(result.exit_code == code);
  CHECK(result.out.empty());
  CHECK_THAT(result.err, Contains(message));
}

}  // namespace

TEST_CASE("mmg-sim estimate: a data sheet becomes a ship that all tools take", "[cli][estimate]") {
  const TemporaryFolder folder;
  const Outcome result = run(folder, "mmg-sim estimate mariner -v -o ship.json");
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.err, Contains("propeller/diameter_m is not stated") && Contains("Kristensen"));
  const Json ship = read_json(folder / "ship.json");
  CHECK(ship["uncertainty"]["hull.Y_r"]["sd"].get<double>() > 0.0);
  CHECK(ship["provenance"]["tool"] == "mmg-sim");
  CHECK(ship["coefficient_sources"].size() >= 30);
  done_quietly(folder, "mmg-sim turning --ship ship.json --duration-s 600 --dt-s 0.5 -o turn.csv");
  done_quietly(folder, "mmg-sim draws --ship ship.json --count 2 -o draws");
  const Json draw = read_json(folder / "draws/draw-01.json");
  CHECK(draw["coefficient_shifts"].contains("hull.Y_r"));
  CHECK_FALSE(draw["coefficient_factors"].contains("hull.Y_r"));
  CHECK(read_json(folder / "draws/draws.json")["draws"][1]["coefficient_shifts"]["hull.Y_r"] ==
        draw["coefficient_shifts"]["hull.Y_r"]);
  done_quietly(folder, "mmg-sim zigzag --ship draws/draw-01.json --duration-s 100 --dt-s 0.5 --sample-s 1 -o z.csv");
  const Outcome show = run(folder, "mmg-sim show ship.json");
  CHECK_THAT(show.out, Contains("hull.Y_v") && Contains("Kijima") && Contains("95 % interval"));
  done_quietly(folder, "mmg-sim estimate mariner --quiet -o again.json && cmp again.json again.json");
}

TEST_CASE("mmg-sim estimate: what is wrong is said with key, unit and range", "[cli][estimate]") {
  const TemporaryFolder folder;
  folder.write("block.json", R"({"name": "t", "L_pp_m": 320, "B_m": 58, "d_m": 20.8, "C_b": 8.1})");
  answers(folder, "mmg-sim estimate block.json", 3, "block.json: /C_b: expected a number from 0.25 to 0.98, got 8.1");
  folder.write("feet.json", R"({"name": "t", "L_pp_m": 320, "B_m": 58, "d_m": 68.2, "C_b": 0.81})");
  answers(folder, "mmg-sim estimate feet.json", 3, "feet.json: /d_m: expected 3.867 to 44.62, [m]");
  folder.write("none.json", R"({"name": "t"})");
  answers(folder, "mmg-sim estimate none.json", 3, "/L_pp_m: missing");
  answers(folder, "mmg-sim estimate none.json", 3, "/C_b (or displacement_t): missing");
  answers(folder, "mmg-sim estimate", 2, "give particulars");
  answers(folder, "mmg-sim estimate kvlcc2 --without titanic", 2, "no measured hull 'titanic'");
  folder.write("slender.json",
               R"({"name": "t", "L_pp_m": 100, "B_m": 9, "d_m": 3, "C_b": 0.45, "service_speed_mps": 7})");
  const Outcome warned = run(folder, "mmg-sim estimate slender.json -o slender-ship.json");
  CHECK(warned.exit_code == 0);
  CHECK_THAT(warned.err, Contains("warning") && Contains("L/B is 11.1: outside of"));
}

TEST_CASE("mmg-sim scale: to another size, with what was corrected", "[cli][estimate]") {
  const TemporaryFolder folder;
  done_quietly(folder, "mmg-sim scale --ship kvlcc2-l7 --length-m 320 -o full.json");
  const Json full = read_json(folder / "full.json");
  CHECK(full["scaling"]["corrections"].size() >= 4);
  done_quietly(folder, "mmg-sim turning --ship full.json --duration-s 900 --dt-s 0.5 -o turn.csv");
  done_quietly(folder, "mmg-sim scale --ship esso-osaka-3m --length-m 325 -o esso.json");
  done_quietly(folder, "mmg-sim show esso.json");
  answers(folder, "mmg-sim scale --ship kvlcc2-l7 --length-m 0", 2, "--length-m");
  answers(folder, "mmg-sim scale --ship full.json --length-m 7 -o full.json", 2, "full.json");
}

TEST_CASE("every tool that reads a ship warns of what is unusual, once", "[cli][estimate]") {
  const TemporaryFolder folder;
  done_quietly(folder, "mmg-sim scale --ship kvlcc2-l7 --length-m 7 -o ship.json");
  Json ship = read_json(folder / "ship.json");
  ship["rudder"]["x_R_m"] = 3.5;
  folder.write("ship.json", leeway::io::to_text(ship));
  for (const char* command : {"mmg-sim show ship.json", "mmg-sim zigzag --ship ship.json --duration-s 20"}) {
    const Outcome result = run(folder, command);
    CAPTURE(command, result.err);
    CHECK(result.exit_code == 0);
    const std::size_t first = result.err.find("/rudder/x_R_m is 3.5; usual: below 0");
    CHECK(first != std::string::npos);
    CHECK(result.err.find("/rudder/x_R_m", first + 1) == std::string::npos);
  }
}
