#pragma once

#include <deque>
#include <optional>
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
  double t_s = 0.0;                     ///< for effects that change with time
};

/// The inputs of one time step: at its start, its middle and its end.
template <typename T>
struct StepInputs {
  Inputs<T> start, middle, end;
};

/// Velocity of the water at the ship, in ship axes [m/s].
template <typename T>
Vec3<T> water_velocity(const Model<T>& model, const Vec3<T>& eta, double t_s) {
  using std::cos, std::sin;
  Situation<T> at;
  at.t_s = t_s;
  at.eta = eta;
  at.cos_psi = cos(eta(2));
  at.sin_psi = sin(eta(2));
  const Vec2<T> nu_c = at.to_ship(model.effects.water(at).velocity);
  return {nu_c(0), nu_c(1), T(0.0)};
}

/// d(eta, nu)/dt; nu is the velocity through the water, which is that over ground unless an effect moves the water.
///   acting  the actuators of `inputs`
template <typename T>
ShipState<T> rate_of_change(const Model<T>& model, const ShipState<T>& state, const Inputs<T>& inputs,
                            const ActingActuators<T>& acting) {
  using std::cos, std::sin;
  Situation<T> at;
  at.t_s = inputs.t_s;
  at.eta = state.eta;
  at.cos_psi = cos(state.eta(2));
  at.sin_psi = sin(state.eta(2));
  at.nu_water = at.nu_ground = state.nu;
  at.recorded_wind = inputs.true_wind;
  Vec2<T> true_wind = inputs.true_wind;
  Vec3<T> extra = Vec3<T>::Zero();  // forces besides those of the modules
  const Effects<T>& effects = model.effects;
  if (effects.moves_water()) {
    const WaterMotion<T> water = effects.water(at);
    at.nu_ground.template head<2>() += at.to_ship(water.velocity);
    at.nu_water(2) -= water.turn(at);
    const Vec2<T> over_ground = at.to_earth(at.nu_ground.template head<2>());
    extra = model.inertia.frame_force(at.to_ship(water.along_path(over_ground)));
  }
  if (effects.blow()) true_wind += effects.wind(at);
  std::optional<Actuators<T>> changed;
  if (effects.act()) {
    changed = inputs.actuators;
    effects.act(*changed);
  }
  if (effects.push()) {
    at.actuators = changed ? &*changed : &acting.actuators;
    extra += effects.force(at);
  }

  if (model.residual_network)
    extra += model.inertia.force_of(acceleration<T>(*model.residual_network, at.nu_ground, inputs.actuators,
                                                    at.to_ship(inputs.true_wind) + at.nu_ground.template head<2>()));

  const T &u = at.nu_ground(0), &v_m = at.nu_ground(1);
  const Vec2<T> apparent_wind = at.to_ship(true_wind) + at.nu_ground.template head<2>();
  const Vec3<T> force = changed ? model.modules.force(at.nu_water, *changed, apparent_wind)
                                : model.modules.force(at.nu_water, acting, apparent_wind);
  return {Vec3<T>(u * at.cos_psi - v_m * at.sin_psi, u * at.sin_psi + v_m * at.cos_psi, state.nu(2)),
          model.inertia.acceleration(state.nu, force + extra)};
}

template <typename T>
ShipState<T> rate_of_change(const Model<T>& model, const ShipState<T>& state, const Inputs<T>& inputs) {
  return rate_of_change(model, state, inputs, ActingActuators<T>(inputs.actuators));
}

/// integrate() with the velocity through the water, before and after.
template <typename T>
ShipState<T> integrate_through_water(const Model<T>& model, const ShipState<T>& state, const StepInputs<T>& inputs,
                                     double dt_s, Integrator integrator) {
  const auto moved = [&](const ShipState<T>& rate, double h) {
    return ShipState<T>{state.eta + h * rate.eta, state.nu + h * rate.nu};
  };
  const ActingActuators<T> start(inputs.start.actuators);
  const ShipState<T> k1 = rate_of_change(model, state, inputs.start, start);
  if (integrator == Integrator::euler) return moved(k1, dt_s);
  const ActingActuators<T> middle(inputs.middle.actuators, start);
  const ShipState<T> k2 = rate_of_change(model, moved(k1, dt_s / 2.0), inputs.middle, middle);
  const ShipState<T> k3 = rate_of_change(model, moved(k2, dt_s / 2.0), inputs.middle, middle);
  const ActingActuators<T> end(inputs.end.actuators, middle);
  const ShipState<T> k4 = rate_of_change(model, moved(k3, dt_s), inputs.end, end);
  return {state.eta + dt_s / 6.0 * (k1.eta + 2.0 * k2.eta + 2.0 * k3.eta + k4.eta),
          state.nu + dt_s / 6.0 * (k1.nu + 2.0 * k2.nu + 2.0 * k3.nu + k4.nu)};
}

/// One step of the classical Runge-Kutta method of fourth order, or of Euler's method, which uses `start` alone. The
/// state's velocity is over ground. In moving water the step is taken with the velocity through the water, so that a
/// steady current carries the track along to rounding.
template <typename T>
ShipState<T> integrate(const Model<T>& model, const ShipState<T>& over_ground, const StepInputs<T>& inputs, double dt_s,
                       Integrator integrator = Integrator::rk4) {
  if (model.effects.moves_water()) {
    ShipState<T> state = over_ground;
    state.nu -= water_velocity(model, state.eta, inputs.start.t_s);
    state = integrate_through_water(model, state, inputs, dt_s, integrator);
    state.nu += water_velocity(model, state.eta, inputs.end.t_s);
    return state;
  }
  return integrate_through_water(model, over_ground, inputs, dt_s, integrator);
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
  std::deque<Inputs<double>> past_;  // where rudders act late: from just before the delay on
  Actuators<double> delayed(const Inputs<double>& inputs) const;
  std::optional<Actuators<double>> acting_;  // where rudders are slow: what acts
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
