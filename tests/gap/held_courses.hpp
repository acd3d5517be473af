#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/random.hpp"
#include "core/units.hpp"
#include "recording/trajectory.hpp"

namespace leeway::test {

/// A ship of 3 m that holds her course at 0.5 m/s, as her sensors without a fault record her: once a second for 240 s,
/// each channel with noise of its own that is correlated.
struct HeldCourses {
  std::uint64_t seed = 1;
  std::size_t recordings = 3;
  double correlation_s = 2.0;  ///< of all noise: 0.03 m, 0.1 deg, 0.01 m/s, 0.1 deg/s; 0: white
  double motion = 1.0;  ///< by that of a calm: 0.1 to 1 deg of yaw within 30 to 90 s, 0.006 and 0.004 m/s of u and v_m
};

inline std::vector<Trajectory> recorded(const HeldCourses& held) {
  constexpr double kStep = 0.1, kDuration = 240.0, kSpeed = 0.5;
  constexpr int kStepsPerSample = 10;
  std::vector<Trajectory> result;
  RandomStream draw(held.seed, "held courses");
  for (std::size_t i = 0; i < held.recordings; ++i) {
    Trajectory run;
    run.name = run.file = "held" + std::to_string(i);
    const double omega = 2.0 * kPi / draw.uniform(30.0, 90.0), course = draw.uniform(-kPi, kPi);
    const double yaw = held.motion * draw.uniform(0.1, 1.0) * kDegree;
    const double kept = held.correlation_s > 0.0 ? std::exp(-1.0 / held.correlation_s) : 0.0;
    std::array<double, 6> noise;
    for (double& e : noise) e = draw.normal();
    double x = 0.0, y = 0.0, surge = 0.0, sway = 0.0;
    for (int k = 0; k * kStep <= kDuration; ++k) {
      const double t = k * kStep, psi = course + yaw * std::sin(omega * t), r = yaw * omega * std::cos(omega * t);
      surge += -kStep / 20.0 * surge + held.motion * 0.002 * std::sqrt(kStep) * draw.normal();
      sway += -kStep / 10.0 * sway + held.motion * 0.002 * std::sqrt(kStep) * draw.normal();
      const double u = kSpeed + surge;
      if (k % kStepsPerSample == 0) {
        for (double& e : noise) e = kept * e + std::sqrt(1.0 - kept * kept) * draw.normal();
        run[Channel::t].push_back(t);
        run[Channel::x0].push_back(x + 0.03 * noise[0]);
        run[Channel::y0].push_back(y + 0.03 * noise[1]);
        run[Channel::psi].push_back(psi + 0.1 * kDegree * noise[2]);
        run[Channel::u].push_back(u + 0.01 * noise[3]);
        run[Channel::vm].push_back(sway + 0.01 * noise[4]);
        run[Channel::r].push_back(r + 0.1 * kDegree * noise[5]);
      }
      x += kStep * (std::cos(psi) * u - std::sin(psi) * sway);
      y += kStep * (std::sin(psi) * u + std::cos(psi) * sway);
    }
    result.push_back(std::move(run));
  }
  return result;
}

}  // namespace leeway::test
