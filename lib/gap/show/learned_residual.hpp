#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gap/show/free_runs.hpp"

namespace leeway::gap {

/// What no formula holds, as a small network on top of a ship.
struct LearnedResidual {
  std::shared_ptr<const ResidualNetwork> network;               ///< of all recordings; nullptr: it predicts no better
  std::vector<std::shared_ptr<const ResidualNetwork>> by_fold;  ///< of what each fold leaves
  /// Mean logarithm of the errors of free runs over what was left out, without the network and with it.
  double log_error_without = kMissing, log_error_with = kMissing;
  std::string problem;  ///< why there is none; empty where it was tried
};

/// Trains a network on the rest for each fold, and on all if that predicts what was left out better by 5 %.
///   starts  smoothed states, from which free runs begin
///   folds   what is left out in turn
LearnedResidual learn_residual(const Campaign& campaign, const std::vector<Smoothed>& starts, const Ship& ship,
                               const std::vector<std::vector<Run>>& folds, const Noise& noise, std::uint64_t seed,
                               std::size_t jobs);

}  // namespace leeway::gap
