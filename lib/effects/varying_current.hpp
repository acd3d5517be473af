#pragma once

#include <cstdint>

#include "core/random.hpp"
#include "core/units.hpp"
#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct VaryingCurrent {
  static constexpr EffectInfo info{
      .name = "varying-current",
      .number = "E2",
      .sentence = "The water moves as a whole, and its motion changes slowly with time, alike on all headings.",
      .formula =
          "each earth component of V is a sum of 64 cosines with the variance current_sd^2 and the spectrum of an "
          "Ornstein-Uhlenbeck process of time constant tau, cut off at omega tau = 20; phases and frequencies from the "
          "seed",
      .source =
          "spectral form of the process (ours): smooth, so that dV/dt exists; equations of motion as steady-current",
      .look_alikes = "steady-current, unmeasured-wind, a drifting sensor bias",
      .separating_maneuver = "the same maneuver at another time",
  };
  static constexpr std::array<EffectParameter, 3> parameters{{
      {"current_sd_mps", "standard deviation of each component of the velocity", 0.0, kNone, 0.0, kUnbounded,
       rayleigh(0.04, 0.15), rayleigh(0.3, 1.5)},
      {"tau_s", "time constant", kNone, kNone, 1e-3, kUnbounded, log_normal(450.0, 0.75, 10.0, 1e4),
       log_normal(3200.0, 0.75, 70.0, 7e4)},
      {"seed", "selects the realization", kNone, 1.0, 0.0, 1e9, uniform(0.0, 1e9), uniform(0.0, 1e9)},
  }};

  static constexpr std::size_t kWaves = 64;
  struct Wave {
    T omega;       // [rad/s]
    double phase;  // [rad]
  };
  T amplitude;  ///< of each wave [m/s]
  std::array<std::array<Wave, kWaves>, 2> waves;

  VaryingCurrent(const std::array<T, 3>& value, const Ship&) : amplitude(value[0] * std::sqrt(2.0 / kWaves)) {
    // Waves of equal variance: their frequencies are quantiles of the spectrum 1/(1 + (omega tau)^2), one at random in
    // each of 64 bands.
    const double last_quantile = std::atan(20.0) / (0.5 * kPi);
    const auto seed = static_cast<std::uint64_t>(seed_of(value[2]));
    for (std::size_t axis = 0; axis < 2; ++axis) {
      RandomStream stream(seed, "varying current", axis);
      for (std::size_t k = 0; k < kWaves; ++k) {
        const double quantile = last_quantile * (static_cast<double>(k) + stream.uniform()) / kWaves;
        waves[axis][k].omega = std::tan(0.5 * kPi * quantile) / value[1];
        waves[axis][k].phase = stream.uniform(0.0, 2.0 * kPi);
      }
    }
  }

  WaterMotion<T> water(const Situation<T>& at) const {
    using std::cos, std::sin;
    WaterMotion<T> result;
    for (Eigen::Index axis = 0; axis < 2; ++axis)
      for (const Wave& wave : waves[static_cast<std::size_t>(axis)]) {
        const T angle = wave.omega * at.t_s + wave.phase;
        result.velocity(axis) += amplitude * cos(angle);
        result.rate(axis) -= amplitude * wave.omega * sin(angle);
      }
    return result;
  }

 private:
  static double seed_of(double value) { return value; }
  template <typename Jet>
  static double seed_of(const Jet& value) {
    return value.a;
  }
};

}  // namespace leeway
