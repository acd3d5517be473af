#pragma once

#include <string>
#include <vector>

#include "gap/comparison.hpp"

namespace leeway::gap {

/// A maneuver that has not been recorded, and what it would tell.
struct NextManeuver {
  std::string name;         ///< "turning circles, 35 deg to both sides"
  std::string command;      ///< of mmg-sim, without the ship
  double duration_s = 0.0;  ///< all runs together
  double p_right = 0.0;     ///< expected probability of the most probable hypothesis afterwards
};

/// What a menu of maneuvers would tell between hypotheses, most telling first. Each maneuver is simulated under each
/// hypothesis in the mean recorded wind; how far the others then are from it, once their parameters have moved within
/// what is left of their uncertainty, follows from the filter with the noise of the recordings (missing: what the
/// autopilot of the day would do).
///   probability  of each hypothesis before; they are scaled to a sum of 1
/// Maneuvers that the ship cannot do are left out; a hypothesis under which the simulator runs away counts as told
/// apart.
std::vector<NextManeuver> next_maneuvers(const Campaign& campaign, const std::vector<const Fitted*>& hypotheses,
                                         std::vector<double> probability, std::size_t jobs, std::uint64_t seed);

/// The expected probability of the most probable of Gaussian alternatives with equal covariance, after a measurement
/// that is normal with sd 1 about them.
///   squared_distance  between each two, in sd
double expected_certainty(const Eigen::MatrixXd& squared_distance, const std::vector<double>& probability,
                          std::uint64_t seed);

}  // namespace leeway::gap
