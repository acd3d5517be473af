#include "dynamics/ship_draws.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/maneuvers.hpp"
#include "dynamics/straight_run.hpp"

namespace leeway {
namespace {

constexpr int kMostRefused = 1000;          // in a row: the law then makes hardly any ship
constexpr double kTurn_lengths = 30.0;      // of a turn, in ship lengths run at the approach speed
constexpr double kSteps_per_length = 20.0;  // of the integration
constexpr double kSteady = 0.05;            // change of the rate of turn over the last quarter of a steady turn
constexpr double kFullRudder = 35.0 * kDegree;
// Speed in a turn, or astern, by that ahead at the same revolutions. Choice: a draw that ran away reached 4.8 m/s; at 1
// by surge a draw of vectwin-3m at its stated widths is refused as well.
constexpr double kRunsAway = 2.0;

// Full rudder from a straight run with surge u, revolutions as at the start.
bool turns(const Ship& ship, double u, double rudder) {
  const double length_s = ship.particulars.L_pp / u, dt_s = length_s / kSteps_per_length;
  SimulatedShip turning(ship, u);
  Actuators<double> command = ship.initial_actuators();
  order_rudders(ship, rudder, command);
  const int steps = static_cast<int>(kTurn_lengths * kSteps_per_length);
  double least = INFINITY, most = -INFINITY;
  for (int k = 0; k < steps; ++k) {
    turning.step(command, Vec2<double>::Zero(), dt_s);
    if (!turning.is_finite() || turning.state.nu.head<2>().norm() > kRunsAway * u) return false;
    const double to_rudder = std::copysign(1.0, rudder) * turning.state.nu(2);
    if (4 * k < 3 * steps) continue;
    least = std::min(least, to_rudder);
    most = std::max(most, to_rudder);
  }
  return least > 0.0 && most - least < kSteady * most;
}

// Twin rudders turned to throw the race ahead, revolutions as at the start: the faster she goes astern, the more race
// they catch.
bool backs(const Ship& ship, double u) {
  const double dt_s = ship.particulars.L_pp / u / kSteps_per_length;
  SimulatedShip backing(ship, u);
  Actuators<double> command = ship.initial_actuators();
  for (const Actuator& actuator : ship.actuators) {
    if (actuator.channel == Channel::delta_p) command[actuator.channel] = actuator.min;
    if (actuator.channel == Channel::delta_s) command[actuator.channel] = actuator.max;
  }
  for (int k = 0; k < static_cast<int>(kTurn_lengths * kSteps_per_length); ++k) {
    backing.step(command, Vec2<double>::Zero(), dt_s);
    if (!backing.is_finite() || backing.state.nu.head<2>().norm() > kRunsAway * u) return false;
  }
  return true;
}

}  // namespace

bool runs_and_turns(Ship ship, double speed_mps) {
  ship.effects.clear();
  try {
    const std::vector<Actuator> propulsion = ship.propulsion();
    if (propulsion.empty()) return true;
    if (!(steady_speed(ship, propulsion.front().max) >= speed_mps)) return false;
    const double u = steady_speed(ship, propulsion.front().initial);
    const bool has_rudders =
        std::ranges::any_of(ship.actuators, [](const Actuator& actuator) { return actuator.is_rudder(); });
    if (u > 0.0 && ship.has_twin_rudders() && !backs(ship, u)) return false;
    return !has_rudders || !(u > 0.0) || (turns(ship, u, kFullRudder) && turns(ship, u, -kFullRudder));
  } catch (const NumericalError&) {
    return false;
  }
}

ShipDraws::ShipDraws(const Ship& ship, double spread, std::uint64_t seed, double recorded_speed_mps)
    : ship_(ship),
      law_(coefficient_law(ship)),
      spread_(spread),
      speed_mps_(recorded_speed_mps > 0.0 ? recorded_speed_mps : ship.u0_mps),
      seed_(seed) {
  // What the ship itself cannot do is asked of none of its draws.
  if (!runs_and_turns(ship_, speed_mps_)) speed_mps_ = -INFINITY;
}

ShipDraw ShipDraws::draw(int number) const {
  RandomStream random(seed_, "draws of a ship", static_cast<std::uint64_t>(number));
  for (int refused = 0; refused < kMostRefused; ++refused) {
    ShipDraw result{ship_, draw_factors(law_, spread_, random), refused};
    result.ship.multiply(result.factors);
    const bool is_readable = std::ranges::all_of(result.ship.coefficient_factors, [](const CoefficientFactor& by) {
      return by.factor >= kFactorRange.low && by.factor <= kFactorRange.high;
    });
    if (!is_readable) continue;
    if (speed_mps_ == -INFINITY || runs_and_turns(result.ship, speed_mps_)) return result;
  }
  throw NumericalError(
      fmt::format("the ship '{}': of {} draws from its stated uncertainty times {} none reaches {} m/s and turns "
                  "steadily; state less uncertainty, or take a smaller spread",
                  ship_.name, kMostRefused, spread_, speed_mps_));
}

io::Json ShipDraws::json(io::Json of_ship, const ShipDraw& draw, int number) const {
  of_ship["name"] = fmt::format("{}-draw-{:02}", ship_.name, number);
  return multiplied(
      std::move(of_ship), draw.factors,
      fmt::format("draw {} with seed {} from the uncertainty of '{}' times {}", number, seed_, ship_.name, spread_));
}

}  // namespace leeway
