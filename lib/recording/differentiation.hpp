#pragma once

#include <span>
#include <vector>

namespace leeway {

/// The time derivative of a channel in each of its samples: the slope there of the cubic that fits the samples around
/// it best (Savitzky & Golay 1964, for any spacing), so that a channel without noise is differentiated to the fourth
/// order of the sampling time. The window is cut at holes of more than 1.5 usual steps and at the ends; where it holds
/// fewer than four samples the polynomial is lower. NaN where a sample is missing or has no neighbor.
///   t         [s], increasing; as many as `values`
///   window_s  width of the window; 0: the sample and two on each side
std::vector<double> derivative(std::span<const double> t, std::span<const double> values, double window_s = 0.0);

}  // namespace leeway
