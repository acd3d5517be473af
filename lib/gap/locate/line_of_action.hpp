#pragma once

#include <optional>
#include <vector>

#include "gap/locate/block_evidence.hpp"

/// Where along the ship the missing side force acts: x_F/L_pp, forward of midship positive.
namespace leeway::gap {

/// N against Y of the smoothed residual; the error from leaving out groups of blocks that are long enough to differ.
///   residual  of smoothed_residual()
std::optional<Estimate> line_of_action(const Campaign& campaign, const FittedNull& fit,
                                       const std::vector<Block>& blocks, const std::vector<Eigen::Matrix3Xd>& residual);

/// The same from the forces in located intervals, which are estimated without shrinking them; nothing where it is known
/// no better than to a fifth of the length.
std::optional<Estimate> line_of_action(const Campaign& campaign, const std::vector<Interval>& intervals);

}  // namespace leeway::gap
