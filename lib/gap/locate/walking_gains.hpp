#pragma once

#include <vector>

#include "gap/locate/block_evidence.hpp"

namespace leeway::gap {

/// Each module's gain as a random walk over the blocks, by its Bayes factor; those that leave less residual than there
/// was, best first.
///   modules  those of the evidence
std::vector<WalkingGain> walking_gains(const Campaign& campaign, const FittedNull& fit, const BlockEvidence& evidence,
                                       const std::vector<Module>& modules, std::size_t jobs);

}  // namespace leeway::gap
