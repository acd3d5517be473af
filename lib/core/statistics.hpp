#pragma once

#include <span>
#include <vector>

/// Levels and scales that a few wild values do not move.
namespace leeway {

/// The value that half of the others do not exceed; of two in the middle the upper one; 0 for none.
double median(std::vector<double> values);

/// Of values in ascending order, at least one, that which this share (0 to 1) of the others does not exceed.
double quantile(std::span<const double> sorted, double share);

/// The standard deviation of a normal distribution around 0 with this median of absolute values: 1.4826 times it; 0 for
/// none. Source: Hampel (1974), J. American Statistical Association 69.
double robust_sd(std::vector<double> values);

}  // namespace leeway
