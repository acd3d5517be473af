// What is said of a ship, and of runs that it does not do as they were asked for.

#include <algorithm>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "ensemble.hpp"
#include "io/json.hpp"

using namespace leeway;
using namespace test;
using Catch::Matchers::Contains;

namespace {

// A ship whose file changes coefficients, states a posterior and adds an effect and a network.
void write_changed_ship(const TemporaryFolder& folder) {
  io::Json ship = io::read_json(LEEWAY_SOURCE_FOLDER "/configs/ships/kvlcc2-l7.json");
  ship["name"] = "kvlcc2-l7, fitted";
  ship["coefficient_factors"] = {{"hull.Y_v", 1.07}, {"source", "a test"}};
  ship["coefficient_shifts"] = {{"hull.Y_r", -0.02}};
  ship["coefficient_covariance"] = {{"names", {"hull.Y_v", "hull.N_v", "hull.N_r"}},
                                    {"matrix", {{0.01, 0.009, 0.0}, {0.009, 0.01, 0.0}, {0.0, 0.0, 0.0004}}}};
  ship["effects"] = {{{"type", "fouling"}, {"resistance_increase", 0.1}}};
  io::Json inputs = io::Json::array();
  for (const char* name : {"u_mps", "vm_mps", "r_radps", "delta_rad"})
    inputs.push_back({{"name", name}, {"mean", 0.0}, {"sd", 1.0}, {"low", -0.5}, {"high", 1.5}});
  ship["residual_network"] = {{"source", "a network of a test"},
                              {"inputs", inputs},
                              {"layers",
                               {{{"weights", {0.1, 0, 0, 0, 0, 0.1, 0, 0}}, {"biases", {0, 0}}},
                                {{"weights", {0.001, 0, 0, 0.001, 0, 0}}, {"biases", {0, 0, 0}}}}}};
  folder.write("ship.json", io::to_text(ship));
}

}  // namespace

TEST_CASE("mmg-sim show: factors, shifts, effects, network and posterior are printed", "[cli][mmg-sim]") {
  const TemporaryFolder folder;
  write_changed_ship(folder);
  const std::string text = done(folder, "mmg-sim show ship.json").out;
  for (const char* part :
       {"kvlcc2-l7, fitted: ", "changed coefficients", "hull.Y_v                   x 1.07",
        "hull.Y_r                   x 1 - 0.02", "posterior (coefficient_covariance)",
        "hull.N_r                         0.02", "+0.90  hull.Y_v and hull.N_v", "residual network", "2 x 4; 3 x 2; ",
        "delta_rad     -0.5 .. 1.5", "a network of a test", "effects", "fouling: resistance_increase 0.1"})
    CHECK_THAT(text, Contains(part));
  // A ship without these says nothing of them.
  const std::string plain = done(folder, "mmg-sim show kvlcc2-l7").out;
  for (const char* part : {"changed coefficients", "posterior", "residual network", "\neffects"})
    CHECK_THAT(plain, !Contains(part));
}

TEST_CASE("mmg-sim: an uncertainty of what is no coefficient is refused by all that read the ship", "[cli][mmg-sim]") {
  const TemporaryFolder folder;
  io::Json ship = io::read_json(LEEWAY_SOURCE_FOLDER "/configs/ships/kvlcc2-l7.json");
  ship["uncertainty"]["hull.Yv"] = 0.1;
  folder.write("ship.json", io::to_text(ship));
  for (const char* command : {"zigzag --ship ship.json -o z.csv", "show ship.json"})
    check_refused(folder, std::string("mmg-sim ") + command, 3,
                  "ship.json: /uncertainty/hull.Yv: 'hull.Yv' is not an uncertain parameter of this ship; did you mean "
                  "'hull.Y_v'");
}

TEST_CASE("mmg-sim show --json: the same for programs", "[cli][mmg-sim]") {
  const TemporaryFolder folder;
  write_changed_ship(folder);
  const io::Json json = io::parse_json(done(folder, "mmg-sim show ship.json --json").out, "stdout");
  CHECK(json["name"] == "kvlcc2-l7, fitted");
  CHECK(json["particulars"]["L_pp_m"] == 7.0);
  CHECK(json["actuators"][0]["max_deg"].get<double>() == Approx(35.0));
  CHECK(json["coefficient_factors"] == io::Json{{"hull.Y_v", 1.07}});
  CHECK(json["coefficient_shifts"] == io::Json{{"hull.Y_r", -0.02}});
  CHECK(json["effects"][0]["type"] == "fouling");
  CHECK(json["effects"][0]["resistance_increase"] == 0.1);
  CHECK(json["coefficient_covariance"]["coefficients"][2]["sd"].get<double>() == Approx(0.02));
  CHECK(json["coefficient_covariance"]["strongest_correlations"].size() == 1);
  CHECK(json["coefficient_covariance"]["strongest_correlations"][0]["correlation"].get<double>() == Approx(0.9));
  CHECK(json["residual_network"]["inputs"][3]["name"] == "delta_rad");
  const auto& all = json["coefficients"];
  const auto Y_v = std::find_if(all.begin(), all.end(), [](const auto& c) { return c["name"] == "hull.Y_v"; });
  REQUIRE(Y_v != all.end());
  CHECK((*Y_v)["value"].get<double>() == Approx(-0.315 * 1.07));
  CHECK(json["straight_run"]["at_initial_revolutions"]["u_mps"].get<double>() < 1.18);  // it is fouled
  CHECK(json["provenance"]["inputs"][0]["file"] == "ship.json");
  for (const std::string& name : io::config_names("ships")) {
    const io::Json shipped = io::parse_json(done(folder, "mmg-sim show --json " + name).out, name);
    CHECK(shipped["name"] == name);
    CHECK(shipped["effects"].empty());
    CHECK(shipped["residual_network"].is_null());
  }
}

TEST_CASE("mmg-sim: results of a changed ship carry its new name", "[cli][mmg-sim]") {
  const TemporaryFolder folder;
  write_changed_ship(folder);
  folder.write("e.json", R"([{"type": "steady-current", "current_speed_mps": 0.05, "current_set_deg": 90},
                             {"type": "fouling", "resistance_increase": 0.2}])");
  const auto ship_of = [&](const std::string& arguments, const std::string& file) {
    done(folder, "mmg-sim zigzag --duration-s 5 -o z.csv --indices i.json " + arguments);
    return io::read_json(folder / file)["provenance"]["ship"];
  };
  for (const std::string file : {"z.csv.provenance.json", "i.json"}) {
    CHECK(ship_of("--ship kvlcc2-l7", file)["name"] == "kvlcc2-l7");
    CHECK(ship_of("--ship ship.json", file)["name"] == "kvlcc2-l7, fitted");
    const io::Json with = ship_of("--ship kvlcc2-l7 --effect e.json", file);
    CHECK(with["name"] == "kvlcc2-l7 with steady-current, fouling");
    CHECK(with["effects"] == io::Json{"steady-current", "fouling"});
  }
  CHECK(io::read_json(folder / "i.json")["ship"]["name"] == "kvlcc2-l7 with steady-current, fouling");
  done(folder, "mmg-sim replay --ship kvlcc2-l7 --effect e.json z.csv --restart-steps 3 --prediction -o p");
  CHECK(io::read_json(folder / "p/prediction.json")["provenance"]["ship"]["name"] ==
        "kvlcc2-l7 with steady-current, fouling");
}

TEST_CASE("mmg-sim: revolutions, wind and rudder angles that do not do what they seem to are told", "[cli][mmg-sim]") {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& arguments) {
    return done(folder, "mmg-sim " + arguments + " -o r.csv").err;
  };
  for (const std::string maneuver : {"zigzag", "turning", "random", "pull-out --hold-s 5 --duration-s 5"}) {
    CAPTURE(maneuver);
    const std::string base = maneuver + (maneuver.find("duration") == std::string::npos ? " --duration-s 5" : "");
    CHECK(said(base + " --ship esso-osaka-3m").empty());
    const std::string told = said(base + " --ship esso-osaka-3m --u0-mps 0.4 --n-p-rps 5");
    CHECK_THAT(told, Contains("warning") && Contains("0.4 m/s (--u0-mps)") && Contains("5 1/s (--n-p-rps)") &&
                         Contains("comes to 0.1977 m/s") && Contains("10.12 1/s would hold"));
    if (maneuver == "random") continue;  // which orders other revolutions at once where none are given
    CHECK_THAT(said(base + " --ship esso-osaka-3m --u0-mps 0.6"), Contains("do not belong together"));
  }
  CHECK(said("berthing --ship vectwin-3m --duration-s 5").empty());
  CHECK_THAT(said("berthing --ship vectwin-3m --duration-s 5 --u0-mps 0.5 --n-p-rps 5"), Contains("do not belong"));
  // One that holds the speed by the tool's own answer is fine.
  CHECK(said("zigzag --ship esso-osaka-3m --duration-s 5 --u0-mps 0.4 --n-p-rps 10.12").empty());

  CHECK_THAT(said("zigzag --ship kvlcc2-l7 --duration-s 5 --wind-speed-mps 8"),
             Contains("'kvlcc2-l7' has no wind module: the wind of 8 m/s has no effect"));
  done(folder, "cp r.csv w.csv");
  CHECK_THAT(said("replay --ship kvlcc2-l7 w.csv"), Contains("w.csv: the ship 'kvlcc2-l7' has no wind module"));
  CHECK(said("zigzag --ship esso-osaka-3m --duration-s 5 --wind-speed-mps 2").empty());

  CHECK_THAT(said("turning --ship kvlcc2-l7 --duration-s 5 --rudder-deg 50"),
             Contains("50 deg are ordered, beyond the limits -35 to 35 deg of delta"));
  CHECK_THAT(said("zigzag --ship kvlcc2-l7 --duration-s 5 --rudder-deg -40"), Contains("limits -35 to 35 deg"));
  CHECK(said("turning --ship kvlcc2-l7 --duration-s 5 --rudder-deg 35").empty());
  CHECK(done(folder, "mmg-sim turning --ship kvlcc2-l7 --duration-s 5 --rudder-deg 50 --quiet -o r.csv").err.empty());
  folder.write("spec.json", R"({"ship": "kvlcc2-l7", "sets": [{"name": "A", "runs": [
      {"maneuver": "zigzag", "rudder_deg": 40, "duration_s": 5, "wind": {"speed_mps": 3, "dir_deg": 0}}]}]})");
  CHECK_THAT(done(folder, "mmg-sim dataset spec.json -o d").err,
             Contains("limits -35 to 35 deg") && Contains("no wind module: the wind of 3 m/s"));
}
