#pragma once

#include "effects/effect.hpp"
#include "effects/ou_waves.hpp"

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
      .formula_sd = 0.0,
  };
  static constexpr std::array<EffectParameter, 3> parameters{{
      {"current_sd_mps", "standard deviation of each component of the velocity", 0.0, kNone, 0.0, kUnbounded,
       rayleigh(0.04, 0.15), rayleigh(0.3, 1.5)},
      {"tau_s", "time constant", kNone, kNone, 1e-3, kUnbounded, log_normal(450.0, 0.75, 10.0, 1e4),
       log_normal(3200.0, 0.75, 70.0, 7e4)},
      {"seed", "selects the realization", kNone, 1.0, 0.0, 1e9, uniform(0.0, 1e9), uniform(0.0, 1e9)},
  }};

  T sd;  ///< of each component [m/s]
  std::array<OuWaves<T>, 2> waves;

  VaryingCurrent(const std::array<T, 3>& value, const Ship&)
      : sd(value[0]),
        waves{OuWaves<T>(value[1], value[2], "varying current", 0),
              OuWaves<T>(value[1], value[2], "varying current", 1)} {}

  WaterMotion<T> water(const Situation<T>& at) const {
    WaterMotion<T> result;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      result.velocity(static_cast<Eigen::Index>(axis)) = sd * waves[axis].value(at.t_s);
      result.rate(static_cast<Eigen::Index>(axis)) = sd * waves[axis].rate(at.t_s);
    }
    return result;
  }
};

}  // namespace leeway
