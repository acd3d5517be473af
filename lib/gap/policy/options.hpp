#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "gap/policy/policy.hpp"

/// What a caller chooses; stages that work with it include this alone.
namespace leeway::gap {

struct GapLocateOptions {
  bool correct = true;  ///< take the faults that the audit finds out before the fit
  /// Rate of a mismatch, of a fault and of an interval where there is none.
  double false_alarm = kPolicy.detect.false_alarm;
  double step_s = 0.0;  ///< of the filter's grid; 0: chosen by the ship's length
  std::size_t jobs = 1;
  std::uint64_t seed = 1;
  std::function<void(double done, const std::string& note)> progress;  ///< done in 0..1
};

/// Where the next maneuver can be sailed, and with what. Nothing: no limit, and water as deep as in the recordings.
struct NextLimits {
  std::optional<double> length_m, width_m;  ///< of the area, which may lie in any direction
  std::optional<double> depth_m;            ///< of the water there
  std::optional<double> rudder_deg;         ///< largest angle to either side
  std::optional<double> time_s;             ///< for all of it
};

struct GapExplainOptions {
  GapLocateOptions locate;
  std::size_t refitted = kPolicy.compare.refitted;          ///< effects that are fitted without linearization
  std::size_t most_effects = kPolicy.compare.most_effects;  ///< at a time
  bool calibrates = false;                                  ///< coefficients alone: no effect is asked for
  /// Campaigns that are simulated from what is stated and analyzed again, so that probabilities are true of them; 0:
  /// probabilities are evidence times prior.
  std::size_t campaigns = 0;
  NextLimits next;  ///< of what is advised to be recorded
};

}  // namespace leeway::gap
