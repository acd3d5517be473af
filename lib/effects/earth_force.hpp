#pragma once

#include "core/units.hpp"
#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct EarthForce {
  static constexpr EffectInfo info{
      .name = "earth-force",
      .number = "E47",
      .sentence = "An unexplained constant force that keeps its compass direction.",
      .phrase = "a constant force of {force_N} towards {direction_deg}",
      .formula = "force (cos dir, sin dir) in earth axes at midship, N = 0",
      .source = "generic: a competitor that a specific name has to beat",
      .look_alikes = "unmeasured-wind, wave-drift, steady-current",
      .looks_like = {"unmeasured-wind", "wave-drift", "steady-current"},
      .separating_maneuver = "reciprocal runs, different speeds, gusts",
      .formula_sd = 0.0,
      .differs_by_recording = true,
      .is_of_surroundings = true,
      .to_ensemble = EnsembleForm::earth_acceleration,
  };
  static constexpr std::array<EffectParameter, 2> parameters{{
      {"force_N", "force", 0.0, kNone, 0.0, kUnbounded, rayleigh(0.25, 10.0), rayleigh(3.2e4, 2e6)},
      {"direction_deg", "direction that it points to, clockwise from x0", kNone, kNone, -360.0, 360.0, kAnyDirection,
       kAnyDirection},
  }};

  Vec2<T> F;  ///< earth axes [N]

  EarthForce(const std::array<T, 2>& value, const Ship&) {
    using std::cos, std::sin;
    F = {value[0] * cos(value[1] * kDegree), value[0] * sin(value[1] * kDegree)};
  }

  Vec3<T> force(const Situation<T>& at) const {
    const Vec2<T> f = at.to_ship(F);
    return {f(0), f(1), T(0.0)};
  }
};

}  // namespace leeway
