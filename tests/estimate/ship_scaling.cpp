#include "estimate/ship_scaling.hpp"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "dynamics/coefficient_law.hpp"
#include "estimate/ship_estimate.hpp"
#include "forces/registry.hpp"
#include "io/files.hpp"

using namespace leeway;
using namespace leeway::estimate;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

ScaledShip scaled(const std::string& name, double length_m) {
  const Ship ship = read_ship(name);
  return scale_ship(io::read_json(ship.file), ship, length_m);
}

const StandardPropellerCoefficients<double>& propeller(const Ship& ship) {
  return std::get<StandardPropellerCoefficients<double>>(ship.modules->propeller.value());
}
const StandardHullCoefficients<double>& hull(const Ship& ship) {
  return std::get<StandardHullCoefficients<double>>(ship.modules->hull);
}

}  // namespace

TEST_CASE("scale: kvlcc2-l7 to 320 m beside kvlcc2-full", "[estimate][scale]") {
  const ScaledShip result = scaled("kvlcc2-l7", 320.0);
  const Ship& ship = result.ship;
  const Ship full = read_ship("kvlcc2-full");
  CHECK_THAT(ship.scale, WithinAbs(1.0, 1e-9));
  CHECK(ship.particulars.rho == 1026.0);
  CHECK_THAT(ship.particulars.B, WithinRel(full.particulars.B, 0.005));
  CHECK_THAT(ship.particulars.d, WithinRel(full.particulars.d, 0.015));
  CHECK_THAT(ship.u0_mps, WithinRel(full.u0_mps, 1e-3));
  CHECK_THAT(propeller(ship).D_P, WithinRel(full.particulars.L_pp * 0.216 / 7.0, 1e-9));
  const auto& rudder = std::get<StandardRudderCoefficients<double>>(ship.modules->rudder.value());
  CHECK_THAT(rudder.A_R, WithinRel(112.5, 0.01));
  CHECK_THAT(ship.find_actuator(Channel::delta)->rate, WithinRel(full.find_actuator(Channel::delta)->rate, 0.01));
  // The published wake of the ship is 0.35, that of the model 0.40.
  CHECK_THAT(propeller(ship).w_P0, WithinAbs(0.35, 0.03));
  // kvlcc2-full keeps the model's R_0 of 0.022, as its source says: scaled it is that of a ship.
  CHECK(hull(ship).R_0 > 0.010);
  CHECK(hull(ship).R_0 < 0.018);
  CHECK(hull(ship).Y_v == hull(full).Y_v);
  CHECK(ship.initial_actuators()[Channel::n_p] < full.initial_actuators()[Channel::n_p]);
}

TEST_CASE("scale: each correction is named, with the uncertainty that it adds", "[estimate][scale]") {
  const ScaledShip result = scaled("kvlcc2-l7", 320.0);
  const CoefficientLaw before = coefficient_law(read_ship("kvlcc2-l7")), after = coefficient_law(result.ship);
  CHECK(result.corrections.size() >= 4);
  CHECK(result.json["scaling"]["corrections"].size() == result.corrections.size());
  for (const ScaleCorrection& c : result.corrections) {
    CAPTURE(c.name);
    const bool is_coefficient = c.name.find('.') != std::string::npos && !c.name.starts_with("particulars.");
    CHECK((c.added_log_sd > 0.0) == is_coefficient);
    CHECK(c.why.size() > 10);
    for (std::size_t i = 0; i < before.coefficients.size(); ++i)
      if (before.coefficients[i].name == c.name)
        CHECK_THAT(after.coefficients[i].sd, WithinRel(std::hypot(before.coefficients[i].sd, c.added_log_sd), 1e-9));
  }
}

TEST_CASE("scale: water and revolutions are corrections with a size", "[estimate][scale]") {
  const ScaledShip result = scaled("kvlcc2-l7", 320.0);
  const auto find = [&](const std::string& name) {
    const auto found = std::ranges::find_if(result.corrections, [&](const auto& c) { return c.name == name; });
    REQUIRE(found != result.corrections.end());
    return *found;
  };
  CHECK(find("particulars.rho_kgpm3").before == 1000.0);
  CHECK(find("particulars.rho_kgpm3").after == 1026.0);
  CHECK_THAT(find("n_p, initial_rps").before, WithinRel(11.854606 / std::sqrt(320.0 / 7.0), 1e-9));
  CHECK(find("n_p, initial_rps").after == result.ship.initial_actuators()[Channel::n_p]);
}

namespace {

// The same keys, texts and, but for rounding, numbers.
void check_same(const io::Json& a, const io::Json& b) {
  const io::Json one = a.flatten(), other = b.flatten();
  for (const auto& item : one.items()) {
    CAPTURE(item.key());
    REQUIRE(other.contains(item.key()));
    const io::Json& value = other[item.key()];
    if (item.value().is_number())
      CHECK_THAT(value.get<double>(), WithinRel(item.value().get<double>(), 1e-12));
    else
      CHECK(value == item.value());
  }
  CHECK(one.size() == other.size());
}

}  // namespace

TEST_CASE("scale: model to ship and back, by way of a third size, is the same file", "[estimate][scale]") {
  std::vector<io::Json> ships;
  for (const std::string& name : io::config_names("ships"))
    ships.push_back(io::read_json(io::find_config("ships", name)));
  const io::Json particulars = io::read_json(io::find_config("particulars", "s175"));
  io::JsonObject object(particulars, "s175.json");
  ships.push_back(estimate_ship(read_particulars(object), fit_widths({})).json);
  for (const io::Json& json : ships) {
    CAPTURE(json["name"].get<std::string>());
    const Ship ship = parse_ship(json, "ship.json");
    const double L = ship.particulars.L_pp;
    const ScaledShip third = scale_ship(json, ship, L > 20.0 ? 0.1 * L : 30.0 * L);
    const ScaledShip other = scale_ship(third.json, third.ship, L > 20.0 ? 0.05 * L : 50.0 * L);
    check_same(json, scale_ship(other.json, other.ship, L).json);
    // Two steps are one: neither uncertainty nor corrections twice.
    check_same(scale_ship(json, ship, other.ship.particulars.L_pp).json["uncertainty"], other.json["uncertainty"]);
  }
}

TEST_CASE("scale: what somebody has changed since is kept on the way back", "[estimate][scale]") {
  ScaledShip up = scaled("kvlcc2-l7", 320.0);
  up.json["hull"]["R_0"] = 1.1 * up.json["hull"]["R_0"].get<double>();
  up.json["uncertainty"]["hull.Y_v"] = 0.02;
  const ScaledShip back = scale_ship(up.json, up.ship, 7.0);
  CHECK_THAT(hull(back.ship).R_0, WithinRel(1.1 * 0.022, 1e-9));
  CHECK(back.json["uncertainty"]["hull.Y_v"] == 0.02);
  up.json["scaling"]["replaced"][0]["pointer"] = "no pointer";
  CHECK_THROWS_WITH(scale_ship(up.json, up.ship, 7.0), Catch::Matchers::Contains("/scaling"));
}

TEST_CASE("scale: resistance and wake are corrected as their factors have them", "[estimate][scale]") {
  io::Json json = io::read_json(io::find_config("ships", "kvlcc2-l7")), stated = json;
  json["coefficient_factors"] = {{"hull.resistance", 1.3}, {"propeller.1-w_P", 1.1}, {"propeller.1-t_P", 0.95}};
  stated["hull"]["R_0"] = 1.3 * 0.022;
  stated["propeller"]["w_P0"] = 1.0 - 1.1 * 0.6;
  stated["propeller"]["t_P"] = 1.0 - 0.95 * 0.78;
  const Ship with_factors = scale_ship(json, parse_ship(json, "a.json"), 320.0).ship,
             without = scale_ship(stated, parse_ship(stated, "b.json"), 320.0).ship;
  CHECK_THAT(1.3 * hull(with_factors).R_0, WithinRel(hull(without).R_0, 1e-9));
  CHECK_THAT(1.1 * (1.0 - propeller(with_factors).w_P0), WithinRel(1.0 - propeller(without).w_P0, 1e-9));
}

TEST_CASE("scale: effects scale by their units and take no part in corrections, a residual network is dropped",
          "[estimate][scale]") {
  const io::Json plain = io::read_json(io::find_config("ships", "kvlcc2-l7"));
  io::Json json = plain;
  json["effects"] =
      io::Json::array({{{"type", "steady-current"}, {"current_speed_mps", 0.2}, {"current_set_deg", 90.0}},
                       {{"type", "shallow-water"}, {"h_over_T", 1.5}},
                       {{"type", "fouling"}, {"resistance_increase", 0.4}},
                       {{"type", "tug"},
                        {"force_N", 3.0},
                        {"direction_deg", 30.0},
                        {"x_m", 2.0},
                        {"y_m", 0.0},
                        {"t_start_s", 10.0},
                        {"t_end_s", 20.0}},
                       {{"type", "body-force"}, {"X_N", 1.0}, {"Y_N", 0.5}, {"N_Nm", 2.0}},
                       {{"type", "propeller-walk"}, {"c_Y", 0.01}, {"c_N", -0.004}}});
  json["residual_network"] = {{"source", "made for a test"},
                              {"inputs",
                               {{{"name", "u_mps"}, {"mean", 1.0}, {"sd", 0.5}, {"low", 0.0}, {"high", 2.0}},
                                {{"name", "vm_mps"}, {"mean", 0.0}, {"sd", 0.1}, {"low", -0.5}, {"high", 0.5}},
                                {{"name", "r_radps"}, {"mean", 0.0}, {"sd", 0.05}, {"low", -0.2}, {"high", 0.2}},
                                {{"name", "delta_rad"}, {"mean", 0.0}, {"sd", 0.1}, {"low", -0.6}, {"high", 0.6}}}},
                              {"layers",
                               {{{"weights", {2.0, 0.0, 0.0, 1.0}}, {"biases", {0.0}}},
                                {{"weights", {0.2, 0.0, -0.3}}, {"biases", {0.1, 0.0, 0.0}}}}}};
  const ScaledShip up = scale_ship(json, parse_ship(json, "ship.json"), 320.0), bare = scaled("kvlcc2-l7", 320.0);
  const double by = 320.0 / 7.0, force = by * by * by * 1.026;
  const io::Json& e = up.json["effects"];
  CHECK_THAT(e[0]["current_speed_mps"].get<double>(), WithinRel(0.2 * std::sqrt(by), 1e-12));
  CHECK(e[0]["current_set_deg"] == 90.0);
  CHECK(e[1]["h_over_T"] == 1.5);
  CHECK_THAT(e[3]["force_N"].get<double>(), WithinRel(3.0 * force, 1e-12));
  CHECK_THAT(e[3]["x_m"].get<double>(), WithinRel(2.0 * by, 1e-12));
  CHECK_THAT(e[3]["t_end_s"].get<double>(), WithinRel(20.0 * std::sqrt(by), 1e-12));
  CHECK_THAT(e[4]["N_Nm"].get<double>(), WithinRel(2.0 * force * by, 1e-12));
  CHECK(e[5]["c_N"] == -0.004);
  CHECK_FALSE(up.json.contains("residual_network"));
  REQUIRE(up.warnings.size() == 1);
  CHECK_THAT(up.warnings[0], Catch::Matchers::Contains("residual_network"));
  CHECK(up.ship.initial_actuators()[Channel::n_p] == bare.ship.initial_actuators()[Channel::n_p]);
  CHECK(hull(up.ship).R_0 == hull(bare.ship).R_0);
}

TEST_CASE("scale: there and back again is the same ship", "[estimate][scale]") {
  const ScaledShip up = scaled("kvlcc2-l7", 320.0);
  const ScaledShip back = scale_ship(up.json, up.ship, 7.0);
  CHECK_THAT(hull(back.ship).R_0, WithinRel(0.022, 0.02));
  CHECK_THAT(propeller(back.ship).w_P0, WithinAbs(0.40, 0.005));
  CHECK_THAT(back.ship.u0_mps, WithinRel(1.1793, 1e-9));
  CHECK_THAT(back.ship.scale, WithinRel(320.0 / 7.0, 1e-9));
}

TEST_CASE("scale: a small hull without a scale is said to be taken for a ship", "[estimate][scale]") {
  io::Json json = io::read_json(io::find_config("ships", "kvlcc2-l7"));
  json.erase("scale");
  const ScaledShip up = scale_ship(json, parse_ship(json, "ship.json"), 14.0);
  REQUIRE(up.warnings.size() == 1);
  CHECK_THAT(up.warnings[0], Catch::Matchers::Contains("a hull of 7 m") && Catch::Matchers::Contains("`scale`"));
  CHECK(up.ship.particulars.rho == 1000.0);
  CHECK(scaled("kvlcc2-l7", 14.0).warnings.empty());
}

TEST_CASE("scale: a ship of its own size stays as it is", "[estimate][scale]") {
  const ScaledShip same = scaled("kvlcc2-l7", 7.0);
  CHECK(same.corrections.empty());
  CHECK(hull(same.ship).R_0 == 0.022);
}
