#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "gap/fit/null_fit.hpp"

/// Evidence by blocks of time, and what is left out in turn.
namespace leeway::gap {

/// Evidence by blocks of 60 s at 3 m.
struct Blocks {
  std::size_t points = 0;  ///< of one block; the last of a stretch may have fewer
  std::vector<Evidence> evidence;
  std::vector<std::size_t> stretch;  ///< of each
  std::vector<std::size_t> begin;    ///< first point of each in its stretch

  Evidence total() const;
};
Blocks blocks_of(const Campaign& campaign, const FittedNull& fit, const Noise& noise, const ExtraColumns& extra,
                 std::size_t jobs);
/// The same of evidence_of(stretch, points of a block).
Blocks blocks_of(const Campaign& campaign, std::size_t stretches,
                 const std::function<std::vector<Evidence>(std::size_t, std::size_t)>& evidence_of, std::size_t jobs);

/// Blocks that are left out in turn: whole recordings, or pieces of a few.
std::vector<std::vector<std::size_t>> folds_of(const Campaign& campaign, const Blocks& blocks);
/// The evidence of all blocks but those of a fold.
Evidence without(const Evidence& total, const Blocks& blocks, const std::vector<std::size_t>& fold);
/// ln p(what was left out | the rest) by fold, with all that the evidence is about integrated out.
std::vector<double> fold_evidence(const Blocks& blocks, const std::vector<std::vector<std::size_t>>& folds,
                                  const Eigen::VectorXd& theta, const ThetaPrior& prior);
/// Sum over the folds of what `better` predicts better than `than`, and its standard error [nats].
std::pair<double, double> heldout_gain(const std::vector<double>& better, const std::vector<double>& than);

/// How much wider than the model says scores along a direction of (theta, columns) scatter between blocks, at least 1:
/// what correlation between them that the noise model does not know does to errors.
double overdispersion(const Blocks& blocks, const Eigen::VectorXd& direction, const Eigen::VectorXd& fitted);

}  // namespace leeway::gap
