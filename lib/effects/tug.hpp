#pragma once

#include "core/units.hpp"
#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct Tug {
  static constexpr EffectInfo info{
      .name = "tug",
      .number = "E42",
      .sentence = "A tug pushes or pulls at one point of the ship for a while.",
      .phrase = "a tow force: {force_N} towards {direction_deg} clockwise from the bow; from {t_start_s} to {t_end_s}",
      .formula = "(X, Y) = force (cos dir, sin dir) in ship axes, N = x Y - y X, for t_start <= t < t_end",
      .source = "statics",
      .look_alikes = "bank, mooring, fender, a gust",
      .looks_like = {"bank", "mooring", "fender"},
      .separating_maneuver = "none is needed: it begins and ends, and its line of action passes through the bitts",
      .formula_sd = 0.0,
      .bound_to = BoundTo::time,
      .is_of_surroundings = true,
      .to_record = "when tugs push or pull, and how hard",
      .search = SearchStart::interval,
  };
  static constexpr std::array<EffectParameter, 6> parameters{{
      {"force_N", "force on the ship", 0.0, kNone, -kUnbounded, kUnbounded, log_normal(0.5, 1.0, 0.0, 10.0),
       log_normal(1e5, 1.0, 0.0, 2e6), ParameterRole::force},
      {"direction_deg", "direction of the force, clockwise from the bow", kNone, kNone, -360.0, 360.0, kAnyDirection,
       kAnyDirection},
      {"x_m", "point of action ahead of midship", kNone, 0.0, -kUnbounded, kUnbounded, uniform(-1.5, 1.5),
       uniform(-75.0, 75.0), ParameterRole::lever},
      {"y_m", "point of action to starboard", kNone, 0.0, -kUnbounded, kUnbounded, uniform(-0.25, 0.25),
       uniform(-12.5, 12.5)},
      {"t_start_s", "begin, in the run's time", kNone, -kUnbounded, -kUnbounded, kUnbounded, uniform(0.0, 1e5),
       uniform(0.0, 1e5), ParameterRole::begin},
      {"t_end_s", "end", kNone, kUnbounded, -kUnbounded, kUnbounded, uniform(0.0, 1e5), uniform(0.0, 1e5),
       ParameterRole::end},
  }};

  Vec3<T> F;
  T t_start, t_end;

  Tug(const std::array<T, 6>& value, const Ship&) : t_start(value[4]), t_end(value[5]) {
    using std::cos, std::sin;
    const T X = value[0] * cos(value[1] * kDegree), Y = value[0] * sin(value[1] * kDegree);
    F = {X, Y, value[2] * Y - value[3] * X};
  }

  Vec3<T> force(const Situation<T>& at) const {
    if (!(T(at.t_s) < t_start) && T(at.t_s) < t_end) return F;
    return Vec3<T>::Zero();
  }
};

}  // namespace leeway
