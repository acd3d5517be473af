#pragma once

#include <vector>

#include "gap/compare/fitted.hpp"
#include "gap/filter/campaign.hpp"
#include "gap/policy/policy.hpp"
#include "gap/result/next_plan.hpp"

namespace leeway::gap {

/// What would distinguish hypotheses: maneuvers of a menu, two of them, and what was not recorded. Each maneuver is
/// simulated under each hypothesis in the mean recorded wind; how far the others then are from it, once their
/// parameters have moved within what is left of their uncertainty, follows from the filter with the noise of the
/// recordings (missing: what the autopilot of the day would do).
///   probability  of each hypothesis before; what is missing to 1 is of others that were not fitted
/// Maneuvers that the ship cannot do, or not within the limits, are left out; runs are cut where they leave the area,
/// and where the time is over. A hypothesis under which the simulator runs away counts as distinguished.
NextPlan plan_maneuvers(const Campaign& campaign, const std::vector<const Fitted*>& hypotheses,
                        const std::vector<double>& probability, const NextLimits& limits, std::size_t jobs,
                        std::uint64_t seed);

/// Which of these to record, given how certain the best hypothesis is now: the shortest maneuver that decides, else the
/// shorter of two, else what should have been recorded; where nothing decides, what distinguishes most of all.
struct Recommended {
  enum class What { nothing, maneuver, sequence, record } what = What::nothing;
  std::size_t place = 0;  ///< in the plan's list
  double p_right = 0.0;   ///< then
};
///   p_right  probability of the best hypothesis before
Recommended recommended(const NextPlan& plan, double p_right, const Policy& policy = kPolicy);

/// The expected probability of the most probable of Gaussian alternatives with equal covariance, after a measurement
/// that is normal with sd 1 about them.
///   squared_distance  between each two, in sd
///   probability       before; the result is at most their sum
double expected_certainty(const Eigen::MatrixXd& squared_distance, const std::vector<double>& probability,
                          std::uint64_t seed);

}  // namespace leeway::gap
