#pragma once

#include <array>
#include <string>
#include <vector>

#include "gap/policy/options.hpp"

namespace leeway::gap {

/// A maneuver that has not been recorded, and how well it would distinguish hypotheses.
struct NextManeuver {
  std::string name;         ///< "turning circles, 35 deg to both sides"
  std::string command;      ///< of mmg-sim, without the ship
  double duration_s = 0.0;  ///< all runs together
  double p_right = 0.0;     ///< expected probability of the most probable hypothesis afterwards
};

/// Two of them, after both of which more is known than the sum of what each says alone: one tells what the other
/// confounds.
struct NextSequence {
  std::array<std::size_t, 2> maneuvers{};  ///< places in NextPlan::maneuvers
  double duration_s = 0.0, p_right = 0.0;
};

/// Something that was not recorded and would distinguish hypotheses.
struct NextRecord {
  std::string what;      ///< "the water depth", "positions"
  std::string maneuver;  ///< in which it would tell; empty: in the same maneuvers as now
  double p_right = 0.0;
};

/// What to record next, each list the best first. Probabilities are those of the report: what was not fitted has its
/// share, and is never right.
struct NextPlan {
  NextLimits limits;
  std::vector<NextManeuver> maneuvers;
  std::vector<NextSequence> sequences;  ///< that surpass each of the two alone
  std::vector<NextRecord> records;
  double p_reachable = 1.0;  ///< of everything that was fitted: no maneuver can surpass it
};

}  // namespace leeway::gap
