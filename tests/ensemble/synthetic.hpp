#pragma once

#include <cmath>

#include "core/random.hpp"
#include "core/wind.hpp"
#include "recording/trajectory.hpp"

namespace leeway::test {

/// A made-up ship with two rudders, a thruster and wind, integrated by Euler at dt: enough to train on, and free of
/// zeros that would hide a lost term.
inline Trajectory synthetic_recording(std::uint64_t seed, std::size_t points, double dt_s = 1.0,
                                      bool with_wind = true) {
  RandomStream random(seed, "synthetic recording");
  Trajectory t;
  t.name = "synthetic-" + std::to_string(seed);
  t.file = t.name + ".csv";
  double x = 0.0, y = 0.0, psi = random.uniform(-3.0, 3.0), u = 0.3, v = 0.02, r = 0.01, dp = -1.0, ds = 1.2, bt = 5.0;
  const Vec2<double> wind = wind_from_vector(1.5, random.uniform(0.0, 6.0));
  for (std::size_t k = 0; k < points; ++k) {
    if (k % 20 == 0) {
      dp = random.uniform(-1.5, 0.5);
      ds = random.uniform(-0.5, 1.5);
      bt = random.uniform(-20.0, 20.0);
    }
    const std::pair<Channel, double> row[] = {{Channel::t, dt_s * static_cast<double>(k)},
                                              {Channel::u, u},
                                              {Channel::vm, v},
                                              {Channel::r, r},
                                              {Channel::x0, x},
                                              {Channel::y0, y},
                                              {Channel::psi, psi},
                                              {Channel::delta_p, dp},
                                              {Channel::delta_s, ds},
                                              {Channel::n_bt, bt},
                                              {Channel::n_p, 10.0}};
    for (const auto& [channel, value] : row) t[channel].push_back(value);
    if (with_wind) {
      t[Channel::wind_speed].push_back(1.5);
      t[Channel::wind_dir].push_back(std::atan2(wind(1), wind(0)));
    }
    const Vec2<double> a = apparent_wind<double>(wind, psi, u, v);
    const double du = 0.02 * (0.35 - u) - 0.01 * (ds - dp - 1.0) * u - (with_wind ? 0.0005 * a(0) : 0.0);
    const double dv = -0.05 * v - 0.1 * u * r + 0.0003 * bt - (with_wind ? 0.001 * a(1) : 0.0);
    const double dr = -0.15 * r + 0.01 * (dp + ds) * (0.2 + u) + 0.0002 * bt;
    x += dt_s * (u * std::cos(psi) - v * std::sin(psi));
    y += dt_s * (u * std::sin(psi) + v * std::cos(psi));
    psi += dt_s * r;
    u += dt_s * du;
    v += dt_s * dv;
    r += dt_s * dr;
  }
  return t;
}

}  // namespace leeway::test
