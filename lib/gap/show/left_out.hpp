#pragma once

#include <vector>

#include "gap/compare/fitted.hpp"
#include "gap/policy/policy.hpp"
#include "gap/show/free_runs.hpp"

namespace leeway::gap {

/// What theta says of the coefficients: factors other than 1, and differences.
///   least  changes of the logarithm below which a coefficient stays as it is
std::vector<CoefficientFactor> coefficient_changes(const FittedNull& fit, const Eigen::VectorXd& theta,
                                                   double least = kPolicy.show.same_log_factor);

/// The runs of each recording, with the ship as it sails there with the effects at z.
std::vector<ShipOnRuns> by_recording(const Hypothesis& hypothesis, const Eigen::VectorXd& z, const Campaign& campaign,
                                     const std::vector<Run>& runs);

/// Ships for each part that is left out in turn, with what was fitted to the rest: the effects alone, and with the
/// coefficients; one for each recording where the effects differ between recordings.
struct LeftOut {
  std::vector<std::vector<Run>> runs;  ///< by part
  std::vector<Eigen::VectorXd> theta;  ///< likewise
  std::vector<ShipOnRuns> alone, with_coefficients;
  Evidence total;  ///< of all parts
};
LeftOut leave_out_in_turn(const Campaign& campaign, const Hypothesis& hypothesis, const FittedNull& fit,
                          const std::vector<std::vector<std::size_t>>& folds, std::size_t jobs);

}  // namespace leeway::gap
