#pragma once

#include <vector>

#include "dynamics/integrator.hpp"
#include "dynamics/model.hpp"
#include "recording/trajectory.hpp"

namespace leeway {

/// Pose and velocity of a ship.
template <typename T>
struct ShipState {
  Vec3<T> eta = Vec3<T>::Zero();  ///< (x0, y0 [m], psi [rad])
  Vec3<T> nu = Vec3<T>::Zero();   ///< (u, v_m [m/s], r [rad/s]) over ground
};

/// What acts on the ship at one instant.
template <typename T>
struct Inputs {
  Actuators<T> actuators;               ///< actual values
  Vec2<T> true_wind = Vec2<T>::Zero();  ///< from-vector in earth axes [m/s]: wind_from_vector() of core/wind.hpp
};

/// The inputs of one time step: at its start, its middle and its end.
template <typename T>
struct StepInputs {
  Inputs<T> start, middle, end;
};

/// d(eta, nu)/dt.
template <typename T>
ShipState<T> rate_of_change(const Model<T>& model, const ShipState<T>& state, const Inputs<T>& inputs) {
  using std::cos, std::sin;
  const T &psi = state.eta(2), &u = state.nu(0), &v_m = state.nu(1);
  const T c = cos(psi), s = sin(psi);
  // apparent_wind() with the sine and cosine that the kinematics need anyway.
  const Vec2<T>& w = inputs.true_wind;
  const Vec2<T> wind(c * w(0) + s * w(1) + u, -s * w(0) + c * w(1) + v_m);
  return {Vec3<T>(u * c - v_m * s, u * s + v_m * c, state.nu(2)), model.acceleration(state.nu, inputs.actuators, wind)};
}

/// One step of the classical Runge-Kutta method of fourth order, or of Euler's method, which uses `start` alone.
template <typename T>
ShipState<T> integrate(const Model<T>& model, const ShipState<T>& state, const StepInputs<T>& inputs, double dt_s,
                       Integrator integrator = Integrator::rk4) {
  const auto moved = [&](const ShipState<T>& rate, double h) {
    return ShipState<T>{state.eta + h * rate.eta, state.nu + h * rate.nu};
  };
  const ShipState<T> k1 = rate_of_change(model, state, inputs.start);
  if (integrator == Integrator::euler) return moved(k1, dt_s);
  const ShipState<T> k2 = rate_of_change(model, moved(k1, dt_s / 2.0), inputs.middle);
  const ShipState<T> k3 = rate_of_change(model, moved(k2, dt_s / 2.0), inputs.middle);
  const ShipState<T> k4 = rate_of_change(model, moved(k3, dt_s), inputs.end);
  return {state.eta + dt_s / 6.0 * (k1.eta + 2.0 * k2.eta + 2.0 * k3.eta + k4.eta),
          state.nu + dt_s / 6.0 * (k1.nu + 2.0 * k2.nu + 2.0 * k3.nu + k4.nu)};
}

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
  Actuators<double> actuators;  ///< actual values

  /// At the origin, heading along x0, with surge u0 and the initial actuators of the ship.
  explicit SimulatedShip(const Ship& ship_read)
      : ship(ship_read), model(ship_read), actuators(ship_read.initial_actuators()) {
    state.nu(0) = ship_read.u0_mps;
  }
  /// Advances by one RK4 step; `command` holds over the step, each actuator within its limits and its rate.
  void step(const Actuators<double>& command, const Vec2<double>& true_wind, double dt_s,
            Integrator integrator = Integrator::rk4);
  bool is_finite() const { return state.eta.allFinite() && state.nu.allFinite(); }
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
