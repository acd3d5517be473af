#pragma once

#include "gap/compare/comparison.hpp"
#include "gap/policy/options.hpp"
#include "gap/result/findings.hpp"

namespace leeway::gap {

/// Which hypotheses were fitted, and what of them is claimed. Places are those of Comparison::all(); 0: nothing
/// missing.
struct Selection {
  std::vector<std::string> unexcited;  ///< effects of which these recordings say nothing
  std::vector<double> stated;          ///< probabilities when the choice was made
  std::size_t best = 0;                ///< likeliest of those that may be claimed, beside nothing missing
  std::size_t chosen = 0;              ///< what is claimed
  double left_p_value = 1.0;           ///< of what is left beside it
  bool is_negligible = false;          ///< whether that is not worth a word
  /// Model error beside what is claimed, by the typical acceleration, on the axis or in the interval where it is
  /// largest. Below kPolicy.decide.error_of_forms it is what simulators leave that lack nothing: then nothing is called
  /// unknown but a latent force that is sure.
  double error = 0.0;
  /// What the catalogue does not hold, by kind, the likeliest first, beside what is claimed; empty where nobody asks.
  std::vector<LatentForce> latent;
  double latent_log_evidence = 0.0, latent_log_odds = 0.0;  ///< of all kinds together, beside nothing missing
  bool is_latent = false;  ///< whether that is claimed, alone or beside what was chosen
};

/// Fits the likeliest effects one by one, then pairs, places, a tug and terms of the unknown, and chooses: what is
/// stated as likeliest, then effects beside it while something is left, without those that the others have made
/// needless.
///   progress  from 0.45 to 0.88
Selection select(const Campaign& campaign, const Findings& findings, Comparison& comparison,
                 const GapExplainOptions& options);

}  // namespace leeway::gap
