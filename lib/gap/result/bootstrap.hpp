#pragma once

#include <string>
#include <vector>

#include "gap/result/verdict.hpp"

/// A parametric bootstrap: campaigns that were simulated from what is stated, and went through the whole analysis.
namespace leeway::gap {

/// What the analysis said of one simulated campaign. Probabilities are shares of what was fitted: what was not is never
/// simulated.
struct SimulatedAnswer {
  std::vector<std::string> truth;  ///< names of what acted; empty: nothing was missing
  double stated_of_truth = 0.0;    ///< its probability, 0 where it was not fitted
  double stated_of_first = 0.0;    ///< of the likeliest
  bool truth_is_first = false;
  std::vector<double> stated;  ///< probabilities of all that was fitted
  Verdict verdict = Verdict::undecided;
  bool truth_is_claimed = false;  ///< what is claimed is the truth: nothing, where nothing was missing
  bool alarms = false;            ///< something is claimed
};

/// How stated probabilities p become those of the report: p^sharpness, in all as probable as before but for
/// `not_fitted`.
struct Bootstrap {
  std::vector<SimulatedAnswer> campaigns;
  std::size_t failed = 0;   ///< more that could not be simulated or analyzed
  double sharpness = 1.0;   ///< below 1: what was stated had been too certain
  double not_fitted = 0.0;  ///< how often the truth is none of those that were fitted
};

}  // namespace leeway::gap
