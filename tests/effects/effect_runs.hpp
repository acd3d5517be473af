#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "dynamics/model_parts.hpp"
#include "dynamics/simulation.hpp"

namespace leeway::test {

using Parameters = std::vector<std::pair<std::string, std::optional<double>>>;

inline Ship with(Ship ship, const std::string& type, const Parameters& parameters) {
  ship.effects.push_back({type, parameters, "ship.json", "/effects/0"});
  return ship;
}

/// A zigzag and then the rudders and the thruster moving, so that every module works.
inline Trajectory run(const Ship& ship, double duration_s = 60.0, double dt_s = 0.1) {
  SimulatedShip simulated(ship, 0.4 * ship.u0_mps);  // where the thrusters still work
  Trajectory trajectory;
  const Vec2<double> wind = wind_from_vector(0.8, 1.1);
  const auto steps = static_cast<int>(std::lround(duration_s / dt_s));
  for (int k = 0; k <= steps; ++k) {
    append_sample(trajectory, ship, k * dt_s, simulated.state, {simulated.actuators, wind, k * dt_s});
    Actuators<double> command = ship.initial_actuators();
    for (const Actuator& actuator : ship.actuators) {
      if (actuator.is_rudder()) command[actuator.channel] = 0.4 * std::sin(0.2 * k * dt_s) + 0.1;
      if (actuator.channel == Channel::delta_p) command[actuator.channel] -= 0.3;  // rudders not parallel
      if (actuator.channel == Channel::n_bt) command[actuator.channel] = 15.0 * std::cos(0.1 * k * dt_s);
    }
    simulated.step(command, wind, dt_s);
  }
  return trajectory;
}

inline void check_same_bits(const Trajectory& a, const Trajectory& b) {
  for (const Channel channel : {Channel::u, Channel::vm, Channel::r, Channel::x0, Channel::y0, Channel::psi})
    CHECK(a[channel] == b[channel]);
}

inline double largest_difference(const Trajectory& a, const Trajectory& b, Channel channel) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[channel][i] - b[channel][i]));
  return largest;
}

inline Situation<double> at_heading(double psi_deg) {
  Situation<double> at;
  at.t_s = 5.0;
  at.eta = {12.0, -7.0, psi_deg * kDegree};
  at.cos_psi = std::cos(at.eta(2));
  at.sin_psi = std::sin(at.eta(2));
  at.nu_ground = at.nu_water = {0.4, 0.05, 0.02};
  return at;
}

/// What one effect's force is at a heading.
inline Vec3<double> force_of(const std::string& type, const Parameters& parameters, double psi_deg) {
  return Effects<double>(with(read_ship("vectwin-3m"), type, parameters)).force(at_heading(psi_deg));
}

/// (du/dt, dv_m/dt, dr/dt) over ground with an effect, by a short step from a common state.
inline Vec3<double> acceleration(const Ship& ship, const Vec3<double>& nu, const Actuators<double>& actuators,
                                 const Vec2<double>& true_wind = Vec2<double>::Zero()) {
  const Model<double> model(ship);
  const ShipState<double> start{Vec3<double>::Zero(), nu};
  const Inputs<double> inputs{actuators, true_wind, 0.0};
  const double h = 1e-5;
  return (integrate(model, start, {inputs, inputs, inputs}, h).nu - nu) / h;
}

inline Actuators<double> esso_actuators(double delta_deg, double n_p) {
  Actuators<double> a;
  a[Channel::delta] = delta_deg * kDegree;
  a[Channel::n_p] = n_p;
  return a;
}

/// The equations of motion over ground, with the added mass in water that moves.
///   nu, rate  over ground;  nu_c, a  of the water and its change along the ship's path, in ship axes;  F  of the
///   modules
inline void check_moving_water(const Inertia<double>& i, const Vec3<double>& nu, const Vec3<double>& rate,
                               const Vec2<double>& nu_c, const Vec2<double>& a, const Vec3<double>& F) {
  using Catch::Matchers::WithinAbs;
  const double u = nu(0), v = nu(1), r = nu(2), u_r = u - nu_c(0), v_r = v - nu_c(1);
  CHECK_THAT(
      (i.m + i.m_x) * rate(0),
      WithinAbs(F(0) + i.m * v * r + i.m * i.x_G * r * r + i.m_y * v_r * r + i.m_x * (r * nu_c(1) + a(0)), 1e-5));
  CHECK_THAT((i.m + i.m_y) * rate(1) + i.m * i.x_G * rate(2),
             WithinAbs(F(1) - i.m * u * r - i.m_x * u_r * r + i.m_y * (-r * nu_c(0) + a(1)), 1e-5));
  CHECK_THAT((i.I_z + i.m * i.x_G * i.x_G) * rate(2) + i.m * i.x_G * rate(1),
             WithinAbs(F(2) - i.m * i.x_G * u * r, 1e-5));
}

}  // namespace leeway::test
