#pragma once

#include <cmath>
#include <numbers>

namespace leeway {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegree = kPi / 180.0;    ///< [rad]
inline constexpr double kKnot = 1852.0 / 3600.0;  ///< [m/s], by definition of the international nautical mile
inline constexpr double kGravity_mps2 = 9.80665;  ///< standard gravity

constexpr double deg_to_rad(double deg) { return deg * kDegree; }
constexpr double rad_to_deg(double rad) { return rad / kDegree; }

/// The angle [rad] in [-pi, pi] that differs from `angle` by whole turns.
inline double wrap_angle(double angle) { return std::remainder(angle, 2.0 * kPi); }

}  // namespace leeway
