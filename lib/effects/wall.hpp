#pragma once

#include "core/units.hpp"
#include "effects/effect.hpp"

namespace leeway {

/// A straight vertical wall, a quay or a bank: the line at `distance` from the origin of x0, y0 in the direction of the
/// unit vector `towards`. A point p has wall_distance - p . towards [m] of water before the wall, less than zero behind
/// it. A negative wall_distance puts the origin behind the wall.
template <typename T>
struct Wall {
  static constexpr EffectParameter kDistance{"wall_distance_m",
                                             "from the origin of x0, y0 to the wall, at a right angle to it",
                                             kNone,
                                             kNone,
                                             -kUnbounded,
                                             kUnbounded,
                                             uniform(0.0, 30.0),
                                             uniform(0.0, 1500.0),
                                             ParameterRole::wall_distance};
  static constexpr EffectParameter kDirection{"wall_direction_deg",
                                              "direction in which the wall lies from there, clockwise from x0",
                                              kNone,
                                              kNone,
                                              -360.0,
                                              360.0,
                                              kAnyDirection,
                                              kAnyDirection};

  T distance;
  Vec2<T> towards;  ///< earth axes

  Wall(const T& distance_m, const T& direction_deg) : distance(distance_m) {
    using std::cos, std::sin;
    towards = {cos(direction_deg * kDegree), sin(direction_deg * kDegree)};
  }

  T distance_to(const Vec2<T>& p) const { return distance - p.dot(towards); }
};

}  // namespace leeway
