#include "dynamics/imo_criteria.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "dynamics/model.hpp"
#include "effects/description.hpp"

namespace leeway {
namespace {

using io::Json;

constexpr double kSameOrder = 1e-6;  // [rad], between ordered angles
constexpr double kHardestTurn = 35.0 * kDegree, kShortestShip_m = 100.0 * (1.0 - 1e-9);
constexpr double kBeaufort5_mps = 10.7;
constexpr const char* kNoSpeed = "the ship has no speed ahead at the start";

Json not_applied(const std::string& reason) { return Json{{"applies", false}, {"reason", reason}}; }

Json criterion(const std::string& name, const Json& value, double limit, const std::string& unit) {
  return {{"name", name},
          {"value", value},
          {"limit", limit},
          {"unit", unit},
          {"fulfilled", value.is_null() ? Json() : Json(value.get<double>() <= limit)}};
}

// Which of the tests a maneuver is.
struct Tests {
  bool is_hard_turn, is_10_10, is_20_20, is_initial_turning, is_stop;

  // Rudder angles [rad]: what the rudders reach, and the hardest turn that the ship can make.
  Tests(const ManeuverFacts& facts, double reached, double hardest) {
    const auto is = [](double angle, double degrees) {
      return std::abs(std::abs(angle) - degrees * kDegree) < kSameOrder;
    };
    const bool is_turning = facts.maneuver == "turning", is_zigzag = facts.maneuver == "zigzag";
    is_hard_turn = is_turning && is(reached, rad_to_deg(hardest));
    is_10_10 = is_zigzag && is(facts.rudder, 10.0) && is(facts.heading, 10.0);
    is_20_20 = is_zigzag && is(facts.rudder, 20.0) && is(facts.heading, 20.0);
    // The rudder has to stay until the heading has changed by 10 deg.
    const bool is_held = is_turning || (is_zigzag && std::abs(facts.heading) > 10.0 * kDegree - kSameOrder);
    is_initial_turning = is_held && is(facts.rudder, 10.0);
    is_stop = facts.maneuver == "crash-stop";
  }
  bool any() const { return is_hard_turn || is_10_10 || is_20_20 || is_initial_turning || is_stop; }
};

std::string reason_against(const Tests& tests, double L, double V) {
  if (!tests.any())
    return "none of the tests: turning at 35 deg or the ship's largest rudder angle, zigzag 10/10 or 20/20, 10 deg of "
           "rudder, crash stop";
  if (L < kShortestShip_m) return fmt::format("the ship is {:.4g} m long, below 100 m, at full scale", L);
  return V > 0.0 ? "" : kNoSpeed;
}

Json criteria_of(const Tests& tests, const Json& indices, double L, double V) {
  const double L_over_V = L / V;
  // Constant below and above two values of L/V, linear between them.
  const auto by_L_over_V = [&](double quick, double slow) {
    return quick + (slow - quick) * std::clamp((L_over_V - 10.0) / 20.0, 0.0, 1.0);
  };
  Json criteria = Json::array();
  if (tests.is_hard_turn) {
    criteria.push_back(criterion("advance", indices["advance_over_L"], 4.5, "L"));
    criteria.push_back(criterion("tactical_diameter", indices["tactical_diameter_over_L"], 5.0, "L"));
  }
  if (tests.is_initial_turning)
    criteria.push_back(criterion("track_to_10_deg", indices["track_to_10_deg_over_L"], 2.5, "L"));
  if (tests.is_10_10) {
    criteria.push_back(
        criterion("first_overshoot_10_10", indices["first_overshoot_deg"], by_L_over_V(10.0, 20.0), "deg"));
    criteria.push_back(
        criterion("second_overshoot_10_10", indices["second_overshoot_deg"], by_L_over_V(25.0, 40.0), "deg"));
  }
  if (tests.is_20_20)
    criteria.push_back(criterion("first_overshoot_20_20", indices["first_overshoot_deg"], 25.0, "deg"));
  if (tests.is_stop) criteria.push_back(criterion("track_reach", indices["track_reach_over_L"], 15.0, "L"));
  return {{"applies", true},
          {"full_scale", {{"L_pp_m", L}, {"speed_mps", V}, {"L_over_V_s", L_over_V}}},
          {"criteria", criteria}};
}

}  // namespace

io::Json imo_criteria(const io::Json& indices, const ManeuverFacts& facts, const Ship& ship, double speed_mps) {
  const double L = ship.particulars.L_pp * ship.scale, V = speed_mps * std::sqrt(ship.scale);
  // The largest angle that any rudder takes to this side, and the hardest turn up to 35 deg that all can make.
  double reached = 0.0, hardest = kHardestTurn;
  for (const Actuator& actuator : ship.actuators) {
    if (!actuator.is_rudder()) continue;
    const double limit = facts.rudder < 0.0 ? -actuator.min : actuator.max;
    reached = std::max(reached, std::min(std::abs(facts.rudder), limit));
    hardest = std::min(hardest, limit);
  }
  const Tests tests(facts, reached, hardest);
  if (const std::string reason = reason_against(tests, L, V); !reason.empty() && (!tests.any() || L < kShortestShip_m))
    return not_applied(reason);
  if (facts.mean_wind_mps > 0.0) return not_applied("the tests are made in calm weather");
  const Model<double> model(ship);
  const bool is_shallow = std::any_of(ship.effects.begin(), ship.effects.end(), [](const EffectEntry& effect) {
    return effect_named(effect.type).info.changes_depth;
  });
  if (model.moves_water() || model.blows() || model.pushes() || is_shallow)
    return not_applied("the tests are made in deep, still water and calm weather, without other forces on the ship");
  if (!(V > 0.0)) return not_applied(kNoSpeed);
  return criteria_of(tests, indices, L, V);
}

io::Json imo_criteria(const io::Json& indices, const ManeuverFacts& facts, const RecordedTest& test) {
  const Tests tests(facts, std::abs(facts.rudder), test.hardest_rudder);
  if (const std::string reason = reason_against(tests, test.L_pp_m, test.speed_mps); !reason.empty())
    return not_applied(reason);
  if (test.mean_wind_mps > kBeaufort5_mps)
    return not_applied(fmt::format("the wind is {:.3g} m/s at full scale, beyond Beaufort 5", test.mean_wind_mps));
  return criteria_of(tests, indices, test.L_pp_m, test.speed_mps);
}

}  // namespace leeway
