#pragma once

#include <vector>

namespace leeway {

/// Velocities over ground into ship axes, in place, sample by sample; NaN where the heading is missing.
///   u    in: speed to the north-like x0 [m/s]; out: surge
///   vm   in: speed to the east-like y0 [m/s]; out: sway
///   psi  heading [rad], clockwise from x0
void turn_into_ship_axes(std::vector<double>& u, std::vector<double>& vm, const std::vector<double>& psi);

/// The same from speed and course over ground.
///   u   in: speed [m/s]; out: surge
///   vm  in: course [rad], clockwise from x0; out: sway [m/s]
void resolve_course(std::vector<double>& u, std::vector<double>& vm, const std::vector<double>& psi);

}  // namespace leeway
