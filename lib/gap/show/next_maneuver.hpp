#pragma once

#include <string>
#include <vector>

#include "gap/compare/comparison.hpp"
#include "gap/policy/policy.hpp"
#include "gap/result/explanation.hpp"

namespace leeway::gap {

/// How well a menu of maneuvers would distinguish hypotheses, best first. Each maneuver is simulated under each
/// hypothesis in the mean recorded wind; how far the others then are from it, once their parameters have moved within
/// what is left of their uncertainty, follows from the filter with the noise of the recordings (missing: what the
/// autopilot of the day would do).
///   probability  of each hypothesis before; they are scaled to a sum of 1
/// Maneuvers that the ship cannot do are left out; a hypothesis under which the simulator runs away counts as
/// distinguished.
std::vector<NextManeuver> next_maneuvers(const Campaign& campaign, const std::vector<const Fitted*>& hypotheses,
                                         std::vector<double> probability, std::size_t jobs, std::uint64_t seed);

/// Which of these maneuvers to record, given how certain the best hypothesis is now.
struct Recommended {
  std::size_t place = 0;       ///< the shortest that decides; without one, that which distinguishes most
  bool is_worthwhile = false;  ///< whether it makes the best hypothesis more certain
};
///   maneuvers  at least one, best first
///   p_right    probability of the best hypothesis before
Recommended recommended(const std::vector<NextManeuver>& maneuvers, double p_right, const Policy& policy = kPolicy);

/// The expected probability of the most probable of Gaussian alternatives with equal covariance, after a measurement
/// that is normal with sd 1 about them.
///   squared_distance  between each two, in sd
double expected_certainty(const Eigen::MatrixXd& squared_distance, const std::vector<double>& probability,
                          std::uint64_t seed);

}  // namespace leeway::gap
