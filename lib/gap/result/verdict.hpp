#pragma once

#include <cstddef>

namespace leeway::gap {

enum class Verdict { no_mismatch, mismatch, undecided };

/// What the fit and the tests of gap-locate found.
struct TestsFound {
  bool converged = true;
  double effects_p = 1.0,
         intervals_p = 1.0;  ///< of the tests for effects and for intervals, before they share the rate
  double heldout_gain = 0.0, heldout_gain_sd = 0.0;  ///< of the best effect [nats]
  double error_share = 0.0;                          ///< model error by typical acceleration, on the worst axis
  bool is_noise_free = false;
  std::size_t small_intervals = 0;      ///< in which too little acts to be distinguished from the form of the forces
  std::size_t untrained_intervals = 0;  ///< in which an ensemble was not trained
  std::size_t samples = 0;              ///< scalar measurements
  std::size_t effects_tested = 0;
  std::size_t far_parameters = 0;  ///< beyond far_parameter_sd
};

/// What the comparison of hypotheses of gap-explain found.
struct HypothesesFound {
  bool is_named = false;                   ///< whether something is claimed beside nothing missing
  bool has_terms = false;                  ///< whether terms stand for what the catalogue does not hold
  bool best_is_likelier_than_not = false;  ///< whether what may be claimed is likelier than all else together
  bool best_is_significant = false;        ///< whether each of its effects is told from none by its own sd
  double chance_of_best = 1.0;    ///< how often anything is as likely as what may be claimed, where nothing is missing
  bool is_latent = false;         ///< whether what the catalogue does not hold is claimed by what it depends on
  double chance_of_latent = 1.0;  ///< how often anything of that kind is as likely where nothing is missing
  double log_odds_of_chosen = 0.0;    ///< of what is claimed [nats]
  bool is_likelier_than_not = false;  ///< whether anything is stated as likelier than all others and nothing together
  double left_p = 1.0;                ///< of what is left beside what is claimed
  bool is_negligible = false;         ///< whether that is not worth a word
  double error_share = 0.0;           ///< model error beside what is claimed, by the typical acceleration
  double taken_share = 0.0;           ///< of the model error's energy that what is claimed takes away
};

}  // namespace leeway::gap
