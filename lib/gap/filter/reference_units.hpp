#pragma once

#include <cmath>

#include "core/types.hpp"
#include "core/units.hpp"
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

/// Less noise than this (m, m, rad, m/s, m/s, rad/s) is not believed: no sensor shows less, and sampled inputs leave
/// more.
inline Eigen::Vector<double, 6> least_measurement_sd(const Ship& ship) {
  const FitPolicy& of = kPolicy.fit;
  const double scale = std::sqrt(ship.particulars.L_pp / kPolicy.reference_length_m);
  return {of.least_position_sd_m * std::sqrt(scale),
          of.least_position_sd_m * std::sqrt(scale),
          of.least_heading_sd_deg * kDegree,
          of.least_speed_sd_mps * scale,
          of.least_speed_sd_mps * scale,
          of.least_rate_sd_degps * kDegree / scale};
}

}  // namespace leeway::gap
