#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "core/random.hpp"
#include "core/units.hpp"

namespace leeway {

/// A random function of time with the variance 1 and the spectrum of an Ornstein-Uhlenbeck process, cut off at
/// omega tau = 20: a sum of 64 cosines, smooth, so that it has a rate and can be integrated with any time step.
template <typename T>
struct OuWaves {
  static constexpr std::size_t kWaves = 64;
  static inline const double kAmplitude = std::sqrt(2.0 / kWaves);
  struct Wave {
    T omega;       // [rad/s]
    double phase;  // [rad]
  };
  std::array<Wave, kWaves> waves;

  /// A realization for each (seed, purpose, index).
  OuWaves(const T& tau_s, const T& seed, std::string_view purpose, std::uint64_t index) {
    // Waves of equal variance: their frequencies are quantiles of the spectrum 1/(1 + (omega tau)^2), one at random in
    // each of 64 bands.
    const double last_quantile = std::atan(20.0) / (0.5 * kPi);
    RandomStream stream(static_cast<std::uint64_t>(value_of(seed)), purpose, index);
    for (std::size_t k = 0; k < kWaves; ++k) {
      const double quantile = last_quantile * (static_cast<double>(k) + stream.uniform()) / kWaves;
      waves[k].omega = std::tan(0.5 * kPi * quantile) / tau_s;
      waves[k].phase = stream.uniform(0.0, 2.0 * kPi);
    }
  }

  T value(double t_s) const {
    using std::cos;
    T sum(0.0);
    for (const Wave& wave : waves) sum += cos(wave.omega * t_s + wave.phase);
    return kAmplitude * sum;
  }
  T rate(double t_s) const {
    using std::sin;
    T sum(0.0);
    for (const Wave& wave : waves) sum -= wave.omega * sin(wave.omega * t_s + wave.phase);
    return kAmplitude * sum;
  }

  /// Without derivatives.
  static double value_of(double value) { return value; }
  template <typename Jet>
  static double value_of(const Jet& value) {
    return value.a;
  }
};

}  // namespace leeway
