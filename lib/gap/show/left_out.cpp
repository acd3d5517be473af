#include "gap/show/left_out.hpp"

#include <cmath>

#include "gap/policy/policy.hpp"

namespace leeway::gap {

std::vector<CoefficientFactor> coefficient_changes(const FittedNull& fit, const Eigen::VectorXd& theta, double least) {
  std::vector<CoefficientFactor> changes;
  for (Eigen::Index i = 0; i < fit.coefficients(); ++i)
    if (std::abs(theta[i]) > least) changes.push_back(changed(fit.parameters[static_cast<std::size_t>(i)], theta[i]));
  return changes;
}

std::vector<ShipOnRuns> by_recording(const Hypothesis& hypothesis, const Eigen::VectorXd& z, const Campaign& campaign,
                                     const std::vector<Run>& runs) {
  if (!hypothesis.differs()) return {{hypothesis.applied_to(campaign.ship, z), runs}};
  std::vector<ShipOnRuns> result;
  for (std::size_t r = 0; r < campaign.recordings.size(); ++r) {
    result.push_back({hypothesis.applied_to(campaign.ship, z, r), {}});
    for (const Run& run : runs)
      if (campaign.stretches[run.stretch].recording == r) result.back().runs.push_back(run);
  }
  return result;
}

LeftOut leave_out_in_turn(const Campaign& campaign, const Hypothesis& hypothesis, const FittedNull& fit,
                          const std::vector<std::vector<std::size_t>>& folds, std::size_t jobs) {
  LeftOut result;
  const Blocks blocks = blocks_of(campaign, fit, fit.noise, {0, nullptr}, jobs);
  result.total = blocks.total();
  for (const std::vector<std::size_t>& fold : folds) {
    const std::vector<Run>& runs = result.runs.emplace_back(runs_of(campaign, blocks, fold));
    const Eigen::VectorXd& theta = result.theta.emplace_back(refitted(fit, without(result.total, blocks, fold)));
    for (ShipOnRuns& one :
         by_recording(hypothesis, theta.segment(theta.size() - 1 - fit.effects, fit.effects), campaign, runs)) {
      result.with_coefficients.push_back(one);
      result.with_coefficients.back().ship.multiply(coefficient_changes(fit, theta));
      result.alone.push_back(std::move(one));
    }
  }
  return result;
}

}  // namespace leeway::gap
