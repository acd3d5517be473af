#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gap/detect/score_test.hpp"

namespace leeway::gap {

/// What may be missing, by its columns: coordinates that are standard normal before any recording is seen.
struct LinearCandidate {
  Eigen::Index first = 0;                               ///< of its columns
  Eigen::VectorXd z = {};                               ///< its coordinates at its start; as many columns
  std::optional<Eigen::Index> at_start = std::nullopt;  ///< column of what it does there; nothing: it does nothing
};

/// How much evidence candidates gain, each alone, where nothing is missing: the largest gain of each of so many
/// campaigns that are drawn from the linear model, in ascending order [nats]; none where no candidate can be judged.
///   beside  columns of all candidates, theta integrated out; its scores are not looked at
std::vector<double> gains_of_nothing(const Projected& beside, const std::vector<LinearCandidate>& candidates,
                                     std::size_t draws, std::uint64_t seed);

/// How often so much is gained where nothing is missing; beyond what was drawn in inverse proportion to the evidence
/// (Markov's inequality).
///   drawn  ascending, at least one
double chance_of_gain(const std::vector<double>& drawn, double gain);

}  // namespace leeway::gap
