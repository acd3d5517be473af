#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct PropellerWalk {
  static constexpr EffectInfo info{
      .name = "propeller-walk",
      .number = "E24",
      .sentence = "The turning propeller pushes the stern sideways, most of all when it works astern.",
      .phrase = "propeller walk: a side force c_Y of {c_Y}; a moment c_N of {c_N}",
      .formula =
          "Y = c_Y rho D_P^4 n |n|, N = c_N rho D_P^4 L n |n|; for n < 0 both times astern_gain, for a propeller that "
          "reverses. Right-handed: c_Y > 0, c_N < 0, the stern goes to starboard ahead and to port astern",
      .source =
          "form and astern_gain ours; size: the reversed propeller of the Esso Osaka model (esso-osaka-3m) has 0.02 to "
          "0.12 for c_Y at n < 0 and -0.4 of that for c_N. It adds to what the propeller module has",
      .look_alikes = "body-force, rudder-offset",
      .looks_like = {"body-force", "rudder-offset"},
      .separating_maneuver = "pairs of runs with the propeller ahead and astern",
  };
  static constexpr std::array<EffectParameter, 3> parameters{{
      {"c_Y", "side force ahead", 0.0, 0.0, -kUnbounded, kUnbounded, normal(0.0, 0.01, -0.1, 0.1),
       normal(0.0, 0.01, -0.1, 0.1)},
      {"c_N", "moment ahead", 0.0, 0.0, -kUnbounded, kUnbounded, normal(0.0, 0.005, -0.05, 0.05),
       normal(0.0, 0.005, -0.05, 0.05)},
      {"astern_gain", "how much stronger it is at n < 0", kNone, 3.0, 0.0, kUnbounded, log_normal(3.0, 0.5, 1.0, 10.0),
       log_normal(3.0, 0.5, 1.0, 10.0)},
  }};

  T Y, N, astern_gain;  ///< by n |n| [N s^2, N m s^2]

  PropellerWalk(const std::array<T, 3>& value, const Ship& ship) : astern_gain(value[2]) {
    if (!ship.modules->propeller) throw EffectNotApplicable("the ship has no propeller on a fixed shaft");
    const double D2 = std::visit([](const auto& c) { return c.D_P * c.D_P; }, *ship.modules->propeller);
    Y = ship.particulars.rho * D2 * D2 * value[0];
    N = ship.particulars.rho * D2 * D2 * ship.particulars.L_pp * value[1];
  }

  Vec3<T> force(const Situation<T>& at) const {
    const T& n = (*at.actuators)[Channel::n_p];
    const T n2 = n < T(0.0) ? T(-astern_gain * n * n) : T(n * n);
    return {T(0.0), Y * n2, N * n2};
  }
};

}  // namespace leeway
