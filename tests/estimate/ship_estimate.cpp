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
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

io::Json particulars_of(double L, double B, double d, double C_b) {
  return {{"name", "t"}, {"L_pp_m", L}, {"B_m", B}, {"d_m", d}, {"C_b", C_b}};
}

ShipEstimate estimate_of(const io::Json& json) {
  io::JsonObject object(json, "t.json");
  return estimate_unconditioned(read_particulars(object), fit_widths({}));
}

std::string warnings_of(const io::Json& json) {
  std::string all;
  for (const std::string& warning : estimate_of(json).warnings) all += warning + "\n";
  return all;
}

}  // namespace

TEST_CASE("estimate: the whole range of block coefficients makes ships", "[estimate][ship]") {
  for (const double C_b : {0.25, 0.27, 0.4, 0.885, 0.9, 0.98})
    for (const auto& [L, B, d] : {std::tuple{200.0, 20.0, 8.0}, std::tuple{100.0, 20.0, 6.0}}) {
      CAPTURE(C_b, L);
      const ShipEstimate made = estimate_of(particulars_of(L, B, d, C_b));
      CHECK(made.ship.initial_actuators()[Channel::n_p] > 0.0);
    }
  CHECK_THAT(warnings_of(particulars_of(100.0, 20.0, 6.0, 0.98)),
             Contains("at a C_b of 0.98") && Contains("0.55 to 0.85") && Contains("held at"));
}

TEST_CASE("estimate: parameters outside of a formula's range are said with value and range", "[estimate][ship]") {
  io::Json fast = particulars_of(100.0, 14.0, 4.5, 0.5);
  fast["service_speed_mps"] = 15.0;
  CHECK_THAT(warnings_of(fast), Contains("Fr is 0.479: outside of 0 to 0.45, for which Holtrop"));
  CHECK_THAT(warnings_of(particulars_of(100.0, 26.0, 6.5, 0.7)), Contains("L/B is 3.85: outside of 3.9 to 9.5"));
  CHECK_THAT(warnings_of(particulars_of(100.0, 12.0, 6.5, 0.7)), Contains("B/d is 1.85: outside of 2.1 to 4"));
  io::Json flat = particulars_of(100.0, 16.0, 6.0, 0.7);
  CHECK(warnings_of(flat).empty());
  flat["rudder"] = {{"area_m2", 12.0}, {"height_m", 2.0}};
  CHECK_THAT(warnings_of(flat), Contains("aspect ratio is 0.333: outside of 0.5 to 3, for which Fujii"));
  io::Json slow = particulars_of(100.0, 16.0, 6.0, 0.7);
  slow["service_speed_mps"] = 1.0;
  CHECK_THAT(warnings_of(slow), Contains("Froude number of 0.0319"));
  io::Json trimmed = particulars_of(100.0, 16.0, 6.0, 0.7);
  trimmed.erase("d_m");
  trimmed.update({{"d_fore_m", 5.5}, {"d_aft_m", 6.5}});
  CHECK_THAT(warnings_of(trimmed), Contains("trim by the stern, 1 m, is 17 % of the draft"));
  CHECK_THAT(warnings_of(particulars_of(100.0, 16.0, 3.0, 0.65)),
             Contains("at a ballast draft state propeller/diameter_m"));
  CHECK_THAT(warnings_of(particulars_of(7.0, 1.12, 0.42, 0.7)), Contains("/scale is not stated"));
}

TEST_CASE("estimate: a derivative whose formulas differ in sign has no certain sign", "[estimate][ship]") {
  // L/d 45: N_v by Lee et al. is positive.
  const ShipEstimate made = estimate_of(particulars_of(225.0, 25.0, 5.0, 0.6));
  for (const UncertainCoefficient& c : coefficient_law(made.ship).coefficients) {
    if (c.name != "hull.N_v") continue;
    CHECK(c.is_absolute);
    CHECK(std::abs(c.value.value()) < 1.959963985 * c.sd);
  }
  CHECK_THAT(warnings_of(particulars_of(225.0, 25.0, 5.0, 0.6)),
             Contains("hull.N_v") && Contains("its sign is not known"));
}

TEST_CASE("estimate: every coefficient that is listed has a source of its own, formulas with their ranges",
          "[estimate][ship]") {
  io::Json pushed = particulars_of(40.0, 10.0, 2.0, 0.5), twin = particulars_of(150.0, 24.2, 8.6, 0.72);
  for (const double x : {17.0, -17.0})
    pushed["azimuth_thrusters"].push_back(
        {{"x_m", x}, {"y_m", 0.0}, {"diameter_m", 1.3}, {"max_thrust_N", 4e4}, {"max_rps", 6.5}});
  twin["rudder"] = {{"type", "vectwin"}};
  twin["bow_thruster"] = {{"x_m", 60.0}, {"diameter_m", 2.0}, {"max_thrust_N", 1e5}, {"max_rps", 4.0}};
  for (const io::Json& json : {particulars_of(100.0, 16.0, 6.0, 0.7), pushed, twin}) {
    const ShipEstimate made = estimate_of(json);
    for (const UncertainCoefficient& c : coefficient_law(made.ship).coefficients) {
      CAPTURE(c.name);
      CHECK(made.ship.coefficient_sources.contains(c.name));
    }
  }
  const Ship ship = estimate_of(particulars_of(100.0, 16.0, 6.0, 0.7)).ship;
  CHECK_THAT(ship.coefficient_sources.at("hull.Y_v"), Contains("[C_b 0.5 to 0.85, L/B 4.5 to 7.5, B/d 2 to 5]"));
  CHECK_THAT(ship.coefficient_sources.at("propeller.K_T_J"), Contains("Wageningen") && Contains("P/D 0.5 to 1.4"));
  CHECK_THAT(ship.coefficient_sources.at("wind.k_Y"), Contains("Fujiwara") && Contains("no published range known"));
}

TEST_CASE("estimate: thrusters in kN or per minute do not pass silently", "[estimate][ship]") {
  io::Json pushed = particulars_of(40.0, 10.0, 2.0, 0.5);
  pushed["azimuth_thrusters"] =
      io::Json::array({{{"x_m", -17.0}, {"y_m", 0.0}, {"diameter_m", 1.3}, {"max_thrust_N", 40.0}, {"max_rps", 6.5}}});
  CHECK_THAT(warnings_of(pushed), Contains("cannot hold") && Contains("max_thrust_N is in N"));
  CHECK_FALSE(implausible(estimate_of(pushed).ship).empty());
}

TEST_CASE("estimate: the 95 % intervals hold the measured coefficients of hulls that they were fitted without",
          "[estimate][validation][long]") {
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
