#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "dynamics/integrator.hpp"
#include "dynamics/model.hpp"
#include "recording/trajectory.hpp"

namespace leeway {

/// Where an actuator stands after `dt_s` under a constant command, which is first clipped to its limits: the exact
/// solution of y' = clip((command - y) / tau, -K, K), so it does not depend on the time step. tau = 0: the rate K
/// alone. The printed equation of the ensemble paper mixes dimensions; this is the form of its authors' public code.
double respond(const Actuator& actuator, double actual, double command, double dt_s);

/// All actuators of a ship at the middle and the end of a step.
///   actual  at its start;  command  constant over the step
StepInputs<double> respond(const Ship& ship, const Actuators<double>& actual, const Actuators<double>& command,
                           const Vec2<double>& true_wind, double dt_s);

/// A ship that answers to commands: everything a controller in the loop needs. One step is
///   ship.step({delta_p, delta_s, n_p, ...}, wind, 0.1);   then ship.state and ship.actuators are the new ones.
/// Copy it to try alternatives; it owns its model.
struct SimulatedShip {
  Ship ship;
  Model<double> model;
  ShipState<double> state;
  Actuators<double> actuators;  ///< actual values, as a recording would have them
  double t_s = 0.0;

  /// At the origin at t = 0, heading along x0, with surge u0 through the water and the initial actuators of the ship.
  SimulatedShip(const Ship& ship_read, double u0_mps)
      : ship(ship_read), model(ship_read), actuators(ship_read.initial_actuators()) {
    state.nu = water_velocity(model, state.eta, t_s);
    state.nu(0) += u0_mps;
  }
  explicit SimulatedShip(const Ship& ship_read) : SimulatedShip(ship_read, ship_read.u0_mps) {}

  /// Advances by one RK4 step; `command` holds over the step, each actuator within its limits and its rate.
  void step(const Actuators<double>& command, const Vec2<double>& true_wind, double dt_s,
            Integrator integrator = Integrator::rk4);
  /// The same with given inputs; their times are set here.
  void advance(StepInputs<double> inputs, double dt_s, Integrator integrator = Integrator::rk4);
  /// Surge through the water, which differs from that over ground if an effect moves the water.
  double surge_through_water() const { return (state.nu - water_velocity(model, state.eta, t_s))(0); }
  bool is_finite() const { return state.eta.allFinite() && state.nu.allFinite(); }

 private:
  std::deque<Inputs<double>> past_;  // where rudders act, or are recorded, late: from just before the delay on
  Actuators<double> before(const Inputs<double>& inputs, double delay_s) const;
  std::optional<Actuators<double>> unrecorded_;  // where rudders are recorded late: their angles now
  std::optional<Actuators<double>> acting_;      // where rudders are slow: what acts
  void follow(const RudderResponse& response, StepInputs<double>& inputs, double dt_s);
};

/// Appends one sample to a trajectory: states, the ship's actuators, true and apparent wind.
void append_sample(Trajectory& trajectory, const Ship& ship, double t_s, const ShipState<double>& state,
                   const Inputs<double>& inputs);

/// How a run is stepped and sampled. A sample is a whole number of steps, the run a whole number of samples.
struct TimeGrid {
  double dt_s = 0.1, sample_s = 1.0, duration_s = 200.0;

  /// Throws UsageError if the times do not divide.
  void check() const;
  std::size_t steps_per_sample() const;
  std::size_t samples() const;  ///< without the first one, at t = 0
};

/// k steps of `step_s`, free of the digits that rounding leaves behind (0.3 rather than 0.30000000000000004).
double grid_time(std::size_t k, double step_s);

}  // namespace leeway
