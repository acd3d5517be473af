#pragma once

#include <vector>

#include "gap/locate/options.hpp"
#include "gap/locate/patterns.hpp"

namespace leeway::gap {

/// On what the residual depends: a linear and a quadratic function of each variable on each axis, those that hold with
/// Benjamini & Hochberg's (1995) false-discovery rate, most certain first.
///   residual  of smoothed_residual()
std::vector<Regime> regimes_of(const Campaign& campaign, const FittedNull& fit,
                               const std::vector<Eigen::Matrix3Xd>& residual, const LocateOptions& options);

}  // namespace leeway::gap
