#include "ship/plausibility.hpp"

#include <algorithm>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "io/files.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;

namespace {

// What is said of kvlcc2-l7 with this change.
std::string remarks(const io::Json& patch) {
  io::Json json = io::read_json(io::find_config("ships", "kvlcc2-l7"));
  json.merge_patch(patch);
  std::string all;
  for (const std::string& remark : implausible(parse_ship(json, "ship.json"))) all += remark + "\n";
  return all;
}

}  // namespace

TEST_CASE("plausibility: nothing is said of the shipped ships", "[ship][plausibility]") {
  for (const std::string& name : io::config_names("ships")) {
    CAPTURE(name);
    CHECK(implausible(read_ship(name)).empty());
  }
}

TEST_CASE("plausibility: what is unusual is named with the usual range", "[ship][plausibility]") {
  CHECK_THAT(remarks({{"inertia", {{"m", 3270.0}}}}), Contains("/inertia/m") && Contains("kg"));
  CHECK_THAT(remarks({{"inertia", {{"m", 0.05}}}}), Contains("C_b") && Contains("0.35 to 0.95"));
  CHECK_THAT(remarks({{"u0_mps", 15.5}}), Contains("Froude number") && Contains("0 to 0.27"));
  CHECK_THAT(remarks({{"hull", {{"Y_v", 0.315}}}}), Contains("/hull/Y_v") && Contains("below 0"));
  CHECK_THAT(remarks({{"hull", {{"N_r", 0.049}}}}), Contains("/hull/N_r"));
  CHECK_THAT(remarks({{"rudder", {{"x_R_m", 3.5}}}}), Contains("/rudder/x_R_m") && Contains("behind midship"));
  CHECK_THAT(remarks({{"propeller", {{"D_P_m", 0.6}}}}), Contains("/propeller/D_P_m") && Contains("0.15 to 1"));
  CHECK_THAT(remarks({{"particulars", {{"rho_kgpm3", 1.0}}}}), Contains("/particulars/rho_kgpm3"));
  CHECK(remarks({{"hull", {{"Y_v", -0.4}}}}).empty());
}

TEST_CASE("plausibility: slips of sign, unit and place in every part are named", "[ship][plausibility]") {
  for (const char* name : {"Y_vvv", "Y_vrr", "N_vvr", "N_rrr"}) {
    CAPTURE(name);
    const io::Json hull = io::read_json(io::find_config("ships", "kvlcc2-l7"))["hull"];
    CHECK_THAT(remarks({{"hull", {{name, -hull[name].get<double>()}}}}), Contains(std::string("/hull/") + name));
  }
  CHECK_THAT(remarks({{"hull", {{"Y_r", -1.0}}}}), Contains("/hull/Y_r") && Contains("-0.3 to 0.3"));
  CHECK_THAT(remarks({{"hull", {{"X_vvvv", -3.0}}}}), Contains("/hull/X_vvvv") && Contains("-1 to 3"));
  CHECK_THAT(remarks({{"inertia", {{"x_G", 0.3}}}}), Contains("/inertia/x_G") && Contains("-0.1 to 0.1"));
  CHECK_THAT(remarks({{"rudder", {{"x_R_m", -1000.0}}}}), Contains("/rudder/x_R_m by L_pp"));
  CHECK_THAT(remarks({{"rudder", {{"H_R_m", 6.0}}}}), Contains("/rudder/H_R_m by the draft"));
  CHECK_THAT(remarks({{"rudder", {{"a_H", -0.3}}}}), Contains("/rudder/a_H"));
  CHECK_THAT(remarks({{"rudder", {{"x_H", 0.464}}}}), Contains("/rudder/x_H"));
  CHECK_THAT(remarks({{"rudder", {{"l_R", 0.71}}}}), Contains("/rudder/l_R"));
  CHECK_THAT(remarks({{"rudder", {{"gamma_R_negative", -0.4}}}}), Contains("/rudder/gamma_R_negative"));
  CHECK_THAT(remarks({{"rudder", {{"epsilon", 0.01}}}}), Contains("/rudder/epsilon"));
  CHECK_THAT(remarks({{"propeller", {{"K_T", {0.3, 0.3, 0.1}}}}}), Contains("slope of /propeller/K_T"));
}

TEST_CASE("plausibility: actuators in radians or per minute, thrusters in kN, areas beyond a ship's",
          "[ship][plausibility]") {
  const auto changed = [](const char* name, const auto& change) {
    io::Json json = io::read_json(io::find_config("ships", name));
    change(json);
    std::string all;
    for (const std::string& remark : implausible(parse_ship(json, "ship.json"))) all += remark + "\n";
    return all;
  };
  CHECK_THAT(changed("kvlcc2-full", [](io::Json& s) { s["actuators"][0]["rate_degps"] = 0.04; }),
             Contains("rate_degps") && Contains("degrees per second"));
  CHECK_THAT(changed("kvlcc2-full", [](io::Json& s) { s["actuators"][0]["max_deg"] = 0.61; }),
             Contains("/actuators/0/max_deg") && Contains("5 to 180") && Contains("degrees"));
  CHECK_THAT(changed("kvlcc2-full", [](io::Json& s) { s["actuators"][1]["max_rps"] = 100.0; }),
             Contains("propeller's tips") && Contains("per second"));
  CHECK_THAT(changed("ferry-40m", [](io::Json& s) { s["wind"]["A_T_m2"] = 1e6; }), Contains("/wind/A_T_m2"));
  CHECK_THAT(changed("ferry-40m", [](io::Json& s) { s["thrusters"][0]["x_m"] = 170.0; }),
             Contains("/thrusters/0/x_m by L_pp"));
  CHECK_THAT(changed("ferry-40m", [](io::Json& s) { s["thrusters"][1]["K_T"][0] = 4e-4; }),
             Contains("/thrusters/1/K_T/0") && Contains("thrust in N"));
  CHECK_THAT(changed("ferry-40m", [](io::Json& s) { s["actuators"][0]["max_rps"] = 390.0; }),
             Contains("blades' tips of /thrusters/0"));
  CHECK_THAT(changed("vectwin-3m", [](io::Json& s) { s["thrusters"][0]["K_T_positive"] = 1e-3; }),
             Contains("/thrusters/0/K_T_positive"));
}

TEST_CASE("ship: all that is missing is said at once", "[ship]") {
  io::Json json = io::read_json(io::find_config("ships", "kvlcc2-l7"));
  json["hull"].erase("N_v");
  json["hull"].erase("Y_vvr");
  json["propeller"].erase("t_P");
  json["particulars"].erase("B_m");
  CHECK_THROWS_WITH(parse_ship(json, "ship.json"), Contains("/hull/N_v") && Contains("/hull/Y_vvr") &&
                                                       Contains("/propeller/t_P") && Contains("/particulars/B_m"));
  json["hull"].erase("type");  // what else is missing of it depends on that
  CHECK_THROWS_WITH(parse_ship(json, "ship.json"), Contains("/hull/type") && !Contains("/hull/N_v"));
}

TEST_CASE("plausibility: a listener hears of each ship that is read", "[ship][plausibility]") {
  const test::TemporaryFolder folder;
  io::Json json = io::read_json(io::find_config("ships", "kvlcc2-l7"));
  json["rudder"]["x_R_m"] = 3.5;
  io::write_text(folder / "ship.json", io::to_text(json));
  std::vector<std::string> heard;
  listen_to_ships([&](const std::string&, const std::string& warning) { heard.push_back(warning); });
  read_ship(folder / "ship.json");
  listen_to_ships(nullptr);
  read_ship(folder / "ship.json");
  REQUIRE(heard.size() == 1);
  CHECK_THAT(heard[0], Contains("/rudder/x_R_m"));
}
