#pragma once

#include <set>
#include <string>
#include <vector>

#include "gap/detect/blocks.hpp"
#include "gap/detect/screen.hpp"
#include "gap/fit/hypothesis.hpp"

/// Hypotheses with their fits, and what follows from one fit alone.
namespace leeway::gap {

/// A hypothesis with its fit.
struct Fitted {
  Hypothesis hypothesis;
  FittedNull fit;
  double log_evidence = 0.0;          ///< absolute [nats]
  std::vector<double> fold_evidence;  ///< ln p(what was left out | the rest), by fold
  double kappa = 1.0;                 ///< by which correlation between blocks widens variances
  double gain = 0.0, gain_sd = 0.0;   ///< over nothing missing, on what was left out [nats]
};

/// Names of its effects.
std::set<std::string> name_set(const Hypothesis& hypothesis);

/// The best theta near a fit's for other evidence.
Eigen::VectorXd refitted(const FittedNull& fit, const Evidence& evidence);

/// Runs of the coordinates of a hypothesis that belong to one effect, which may differ between recordings.
struct EffectSpan {
  std::size_t effect = 0, effects = 1;  ///< first, and how many, of Hypothesis::effects
  Eigen::Index first = 0, count = 0;    ///< coordinates
};
std::vector<EffectSpan> spans_of(const Hypothesis& hypothesis);

/// How much correlation between blocks widens what is known of the effects' strength: a factor on variances.
double overdispersion_of(const FittedNull& fit, const Blocks& blocks);

}  // namespace leeway::gap
