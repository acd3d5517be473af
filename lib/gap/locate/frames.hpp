#pragma once

#include <vector>

#include "gap/locate/patterns.hpp"

namespace leeway::gap {

/// In which frame the residual is constant: columns that are constant in a frame, by their Bayes factors, best first.
///   residual  of smoothed_residual()
std::vector<Frame> frames_of(const Campaign& campaign, const FittedNull& fit,
                             const std::vector<Eigen::Matrix3Xd>& residual, std::size_t jobs);

}  // namespace leeway::gap
