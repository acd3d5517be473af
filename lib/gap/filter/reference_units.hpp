#pragma once

#include "core/types.hpp"
#include "gap/policy/policy.hpp"
#include "ship/ship.hpp"

/// Accelerations on the three axes in units that compare them.
namespace leeway::gap {

/// Radius of gyration in yaw [m], about that of most ships: an acceleration in yaw is compared with those in surge and
/// sway by what it makes there.
inline double gyration_radius(const Ship& ship) { return kPolicy.detect.gyration_radius_per_L * ship.particulars.L_pp; }

/// What is worth finding on each axis (m/s^2, m/s^2, rad/s^2).
inline Vec3<double> reference_acceleration(const Ship& ship) {
  constexpr double a = kPolicy.detect.reference_acceleration_mps2;
  return {a, a, a / gyration_radius(ship)};
}

}  // namespace leeway::gap
