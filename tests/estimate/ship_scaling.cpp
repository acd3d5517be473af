#include "estimate/ship_scaling.hpp"

#include <cmath>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "dynamics/coefficient_law.hpp"
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
  CHECK(ship.particulars.rho == 1025.0);
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
    CHECK(c.added_log_sd > 0.0);
    CHECK(c.why.size() > 10);
    for (std::size_t i = 0; i < before.coefficients.size(); ++i)
      if (before.coefficients[i].name == c.name)
        CHECK_THAT(after.coefficients[i].sd, WithinRel(std::hypot(before.coefficients[i].sd, c.added_log_sd), 1e-9));
  }
}

TEST_CASE("scale: there and back again is the same ship", "[estimate][scale]") {
  const ScaledShip up = scaled("kvlcc2-l7", 320.0);
  const ScaledShip back = scale_ship(up.json, up.ship, 7.0);
  CHECK_THAT(hull(back.ship).R_0, WithinRel(0.022, 0.02));
  CHECK_THAT(propeller(back.ship).w_P0, WithinAbs(0.40, 0.005));
  CHECK_THAT(back.ship.u0_mps, WithinRel(1.1793, 1e-9));
  CHECK_THAT(back.ship.scale, WithinRel(320.0 / 7.0, 1e-9));
}

TEST_CASE("scale: a ship of its own size stays as it is", "[estimate][scale]") {
  const ScaledShip same = scaled("kvlcc2-l7", 7.0);
  CHECK(same.corrections.empty());
  CHECK(hull(same.ship).R_0 == 0.022);
}
