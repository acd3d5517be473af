#include "estimate/ship_estimate.hpp"

#include <cmath>
#include <set>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "dynamics/coefficient_law.hpp"
#include "dynamics/ship_draws.hpp"
#include "dynamics/straight_run.hpp"
#include "estimate/hull_comparison.hpp"
#include "forces/registry.hpp"
#include "io/files.hpp"
#include "ship/plausibility.hpp"

using namespace leeway;
using namespace leeway::estimate;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("estimate: the 95 % intervals hold the measured coefficients of hulls that they were fitted without",
          "[estimate][validation]") {
  const io::Json result = compare_measured_hulls(measured_hulls());
  CHECK(result["hulls"].size() >= 6);
  const double share = result["within_95"].get<double>() / result["coefficients"].get<double>();
  CAPTURE(result["within_95"], result["coefficients"]);
  CHECK(share >= 0.88);
  CHECK(share <= 0.99);
}

TEST_CASE("estimate: widths shrink where hulls agree, and a hull that is left out does not count",
          "[estimate][widths]") {
  const std::vector<MeasuredHull> hulls = measured_hulls();
  const auto width = [](const std::vector<Width>& widths, const std::string& name) {
    for (const Width& w : widths)
      if (w.name == name) return w;
    throw std::out_of_range(name);
  };
  const std::vector<Width> all = fit_widths(hulls), without = fit_widths(hulls, {"kvlcc2"});
  CHECK(width(all, "hull.Y_v").hulls == width(without, "hull.Y_v").hulls + 1);
  CHECK(width(all, "hull.N_r").sd < 0.5);
  // Of nothing but the prior: Student's t of eight degrees of freedom, 2.306, for the normal law's 1.96.
  CHECK_THAT(width(fit_widths({}), "hull.Y_v").sd, WithinRel(0.15 * 2.3060041 / 1.959963985, 1e-6));
}

TEST_CASE("estimate: shipped particulars make ships that run, turn and state every coefficient", "[estimate][ship]") {
  const std::vector<Width> widths = fit_widths(measured_hulls());
  for (const std::string& name : io::config_names("particulars")) {
    CAPTURE(name);
    const ShipEstimate estimate = estimate_ship(read_particulars(name), widths);
    const Ship& ship = estimate.ship;
    CHECK(implausible(ship).empty());
    CHECK(runs_and_turns(ship, ship.u0_mps));
    CHECK_THAT(steady_speed(ship, ship.initial_actuators()[Channel::n_p]), WithinRel(ship.u0_mps, 1e-3));
    std::set<std::string> absolute;
    for (const UncertainCoefficient& c : coefficient_law(ship).coefficients) {
      CAPTURE(c.name);
      const bool is_of_shape = c.name == "rudder.gain_90deg" || c.name == "propeller.K_T_reversed";
      CHECK((c.is_stated || is_of_shape));
      if (c.is_absolute) absolute.insert(c.name);
    }
    for (const char* sign_uncertain : {"hull.Y_r", "hull.X_vr", "hull.N_vvv"}) CHECK(absolute.contains(sign_uncertain));
    const ShipDraws draws(ship, 1.0, 1);
    for (int i = 0; i < 3; ++i) CHECK(draws.draw(i).refused < 50);
  }
}

TEST_CASE("estimate: VecTwin rudders, side thrusters and azimuth thrusters", "[estimate][ship]") {
  const std::vector<Width> widths = fit_widths({});
  const io::Json vectwin{
      {"name", "v"},
      {"L_pp_m", 150.0},
      {"B_m", 24.2},
      {"d_m", 8.6},
      {"C_b", 0.72},
      {"rudder", {{"type", "vectwin"}}},
      {"bow_thruster", {{"x_m", 60.0}, {"diameter_m", 2.0}, {"max_thrust_N", 1e5}, {"max_rps", 4.0}}}};
  io::JsonObject first(vectwin, "v.json");
  const Ship twin = estimate_ship(read_particulars(first), widths).ship;
  CHECK(twin.has_twin_rudders());
  CHECK(twin.find_actuator(Channel::n_bt) != nullptr);

  io::Json pushed{{"name", "f"}, {"L_pp_m", 40.0}, {"B_m", 10.0}, {"d_m", 2.0}, {"C_b", 0.5}};
  for (const double x : {17.0, -17.0})
    pushed["azimuth_thrusters"].push_back(
        {{"x_m", x}, {"y_m", 0.0}, {"diameter_m", 1.3}, {"max_thrust_N", 4e4}, {"max_rps", 6.5}});
  io::JsonObject second(pushed, "f.json");
  const Ship ferry = estimate_ship(read_particulars(second), widths).ship;
  CHECK_FALSE(ferry.has_propeller());
  CHECK(ferry.modules->thrusters.size() == 2);
  CHECK(steady_speed(ferry, 6.5) > 1.0);
}
