#pragma once

#include <cmath>
#include <numbers>

namespace leeway {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegree = kPi / 180.0;    ///< [rad]
inline constexpr double kKnot = 1852.0 / 3600.0;  ///< [m/s], by definition of the international nautical mile
inline constexpr double kKilometerPerHour = 1000.0 / 3600.0;  ///< [m/s]
inline constexpr double kFoot_m = 0.3048;                     ///< international foot, by definition
/// Farthest time of a sample from zero [s], 3,000 years, our choice: a clock that counts from 1970 is far below, and
/// one hundred thousandth of a second is still resolved.
inline constexpr double kFarthestTime_s = 1e11;
/// Times that lie closer are one [s], our choice: far below any sampling time, and what a clock that counts from 1970
/// still resolves.
inline constexpr double kSameTime_s = 1e-6;
/// Largest angle of a reading [rad], our choice: far above any heading that is counted on and on, and far below where a
/// double no longer says which way it points.
inline constexpr double kLargestAngle = 1e9 * kDegree;
inline constexpr double kGravity_mps2 = 9.80665;  ///< standard gravity

constexpr double deg_to_rad(double deg) { return deg * kDegree; }
constexpr double rad_to_deg(double rad) { return rad / kDegree; }

/// The angle [rad] in [-pi, pi] that differs from `angle` by whole turns.
inline double wrap_angle(double angle) { return std::remainder(angle, 2.0 * kPi); }

}  // namespace leeway
