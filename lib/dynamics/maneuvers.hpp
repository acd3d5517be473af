#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/random.hpp"
#include "dynamics/simulation.hpp"
#include "dynamics/wind_process.hpp"

namespace leeway {

/// A stretch of a maneuver over which one order stands.
struct Phase {
  double start_s = 0.0, end_s = 0.0;
  double order = 0.0;         ///< what sets the phase apart: a rudder angle [rad] or revolutions [1/s]
  bool is_fulfilled = false;  ///< it ended because what it waited for had come, not because its time was over
  bool is_complete = false;   ///< it ended at all
};

/// Decides what is ordered. Commands may lie outside an actuator's limits: each actuator clips its own. The ship that a
/// maneuver was made for must outlive it.
class Maneuver {
 public:
  virtual ~Maneuver() = default;
  /// Called once per time step with rising time; `command` holds the orders of the step before.
  virtual void order(double t_s, const ShipState<double>& state, Actuators<double>& command) = 0;
  /// Whether the run can end. A maneuver that never says so runs for the whole duration.
  virtual bool is_done() const { return false; }
  /// How long the maneuver takes at most; nothing where it takes as long as one likes.
  virtual std::optional<double> longest_s() const { return std::nullopt; }
  /// The phases so far, for maneuvers that consist of them.
  virtual std::vector<Phase> phases() const { return {}; }
};

/// All rudders to one angle at t = 0 and held. delta > 0: to starboard.
std::unique_ptr<Maneuver> turning(const Ship& ship, double rudder_rad);

/// Zigzag test: all rudders to `rudder_rad`; each time the heading has changed by `heading_rad` (> 0) towards the side
/// of the rudder, they are put over. Starts to port if `rudder_rad` < 0. The heading is compared at the time steps.
std::unique_ptr<Maneuver> zigzag(const Ship& ship, double rudder_rad, double heading_rad);

/// New random orders every `ship.random_interval_s` to each actuator that has a distribution in the ship's JSON:
/// normal, clipped to its limits. The ensemble paper's random maneuvers for vectwin-3m.
std::unique_ptr<Maneuver> random_orders(const Ship& ship, RandomStream stream);

/// A heading controller: delta = kp (course - psi) - kd r, the same order to all rudders.
struct CourseKeeper {
  double kp = 1.0;    ///< [rad/rad]
  double kd_s = 1.0;  ///< [rad/(rad/s)]
  double course = 0.0;

  double rudder(const ShipState<double>& state) const { return kp * (course - state.eta(2)) - kd_s * state.nu(2); }
};

/// Gains by the speed at the start: kp = 1, kd = 2 L_pp/u0; the course is the heading there. Our choice; the ships
/// shipped with leeway keep their course. Throws UsageError for a ship that does not go ahead.
CourseKeeper course_keeper(const SimulatedShip& start);

/// Keeps a heading.
std::unique_ptr<Maneuver> straight(const Ship& ship, const CourseKeeper& keeper);

/// Puts one angle to all rudders of the ship, and to thrusters that steer: what it means to them is theirs to say.
void order_rudders(const Ship& ship, double rudder_rad, Actuators<double>& command);

/// The ship at the origin, going straight ahead at u, with the revolutions at which the thrust balances the resistance
/// in calm air (self_propulsion_n() of dynamics/straight_run.hpp). Throws NumericalError where the propeller cannot do
/// it.
SimulatedShip steady_ahead(const Ship& ship, double u_mps);

/// Runs a maneuver from the given state. Throws NumericalError with the time if a state stops being finite.
/// The run ends after the duration, or at the first sample at which the maneuver is done.
///   start       the ship at t = 0
///   wind        the true wind from t = 0 on, held over each time step
///   every_step  receives a row for every time step, where it is not null
Trajectory simulate(SimulatedShip start, Maneuver& maneuver, WindProcess wind, const TimeGrid& grid,
                    Integrator integrator = Integrator::rk4, Trajectory* every_step = nullptr);

}  // namespace leeway
