#pragma once

#include <memory>

#include "core/random.hpp"
#include "dynamics/simulation.hpp"
#include "dynamics/wind_process.hpp"

namespace leeway {

/// Decides what is ordered. Commands may lie outside an actuator's limits: each actuator clips its own. The ship that a
/// maneuver was made for must outlive it.
class Maneuver {
 public:
  virtual ~Maneuver() = default;
  /// Called once per time step with rising time; `command` holds the orders of the step before.
  virtual void order(double t_s, const ShipState<double>& state, Actuators<double>& command) = 0;
};

/// All rudders to one angle at t = 0 and held. delta > 0: to starboard.
std::unique_ptr<Maneuver> turning(const Ship& ship, double rudder_rad);

/// Zigzag test: all rudders to `rudder_rad`; each time the heading has changed by `heading_rad` (> 0) towards the side
/// of the rudder, they are put over. Starts to port if `rudder_rad` < 0. The heading is compared at the time steps.
std::unique_ptr<Maneuver> zigzag(const Ship& ship, double rudder_rad, double heading_rad);

/// New random orders every `ship.random_interval_s` to each actuator that has a distribution in the ship's JSON:
/// normal, clipped to its limits. The ensemble paper's random maneuvers for vectwin-3m.
std::unique_ptr<Maneuver> random_orders(const Ship& ship, RandomStream stream);

/// Runs a maneuver from the given state. Throws NumericalError with the time if a state stops being finite.
///   start  the ship at t = 0;  wind  the true wind from t = 0 on, held over each time step
Trajectory simulate(SimulatedShip start, Maneuver& maneuver, WindProcess wind, const TimeGrid& grid,
                    Integrator integrator = Integrator::rk4);

}  // namespace leeway
