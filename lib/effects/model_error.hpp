#pragma once

#include "effects/effect.hpp"
#include "effects/ou_waves.hpp"

namespace leeway {

template <typename T>
struct ModelError {
  static constexpr EffectInfo info{
      .name = "model-error",
      .number = "-",
      .sentence = "What no model knows: small accelerations that come and go at random, alike in all conditions.",
      .phrase = "random accelerations",
      .formula =
          "accelerations (a_u, a_v, a_r), each a sum of 64 cosines with the variance surge^2, sway^2, yaw^2 and the "
          "spectrum of an Ornstein-Uhlenbeck process of time constant tau, as varying-current; X = (m + m_x) a_u, Y = "
          "(m + m_y) a_v + x_G m a_r, N = (I_z + x_G^2 m) a_r + x_G m a_v",
      .source = "ours: for recordings of which the error of the simulator is known (docs/gap-locate.md)",
      .look_alikes = "unmeasured-wind in gusts",
      .looks_like = {"unmeasured-wind"},
      .separating_maneuver = "none: it repeats nowhere",
      .search = SearchStart::every_fit,
  };
  /// [m/s^2] Of surge and sway: accelerations are the same at any scale (Froude).
  static constexpr Prior kInPlane = log_normal(5e-4, 1.0, 0.0, 0.05);
  static constexpr std::array<EffectParameter, 5> parameters{{
      {"surge_mps2", "standard deviation of the acceleration in surge", 0.0, 0.0, 0.0, kUnbounded, kInPlane, kInPlane},
      {"sway_mps2", "the same in sway", 0.0, 0.0, 0.0, kUnbounded, kInPlane, kInPlane},
      {"yaw_degps2", "the same in yaw", 0.0, 0.0, 0.0, kUnbounded, log_normal(0.04, 1.0, 0.0, 4.0),
       log_normal(8e-4, 1.0, 0.0, 0.08)},
      {"tau_s", "time constant", kNone, 12.0, 1e-3, kUnbounded, log_normal(12.0, 0.5, 1.0, 100.0),
       log_normal(85.0, 0.5, 7.0, 700.0)},
      {"seed", "selects the realization", kNone, 1.0, 0.0, 1e9, uniform(0.0, 1e9), uniform(0.0, 1e9)},
  }};

  Vec3<T> sd;  ///< (m/s^2, m/s^2, rad/s^2)
  std::array<OuWaves<T>, 3> waves;
  Inertia<double> inertia;

  ModelError(const std::array<T, 5>& value, const Ship& ship)
      : sd(value[0], value[1], value[2] * kDegree),
        waves{OuWaves<T>(value[3], value[4], "model error", 0), OuWaves<T>(value[3], value[4], "model error", 1),
              OuWaves<T>(value[3], value[4], "model error", 2)},
        inertia(ship.inertia, ship.particulars) {}

  Vec3<T> force(const Situation<T>& at) const {
    const T a_u = sd(0) * waves[0].value(at.t_s), a_v = sd(1) * waves[1].value(at.t_s);
    const T a_r = sd(2) * waves[2].value(at.t_s);
    const double S = inertia.x_G * inertia.m;
    return {(inertia.m + inertia.m_x) * a_u, (inertia.m + inertia.m_y) * a_v + S * a_r,
            (inertia.I_z + inertia.x_G * S) * a_r + S * a_v};
  }
};

}  // namespace leeway
