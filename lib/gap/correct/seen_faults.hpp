#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gap/fit/null_fit.hpp"
#include "gap/result/sensor_findings.hpp"

namespace leeway::gap {

/// A fault as the filter sees it around a fit.
struct SeenFault {
  Fault fault;                    ///< with the likeliest numbers, and what it gains in what is left out in turn
  double log_bayes_factor = 0.0;  ///< against sound sensors, coefficients free in both, averaged over its usual sizes
  bool is_small = false;          ///< too little to matter
};

struct SeenFaults {
  std::vector<SeenFault> faults;
  /// The largest log Bayes factor of any of them in campaigns in which nothing is wrong, drawn from the linear model,
  /// in ascending order.
  std::vector<double> gains_of_nothing;
};

/// All members of the library but the current, which moves the ship: their columns go through the filter once, as what
/// they add to the measurements along the smoothed path, linear in their numbers. What a channel was corrected for
/// before counts as sound.
SeenFaults seen_faults(const Campaign& campaign, const FittedNull& fit, std::size_t jobs, std::uint64_t seed);

/// The campaign with the numbers that its recordings were corrected by free, as far as they are left open: columns of
/// the measurement function, which fits take along with the coefficients, so that each hypothesis has its own. As it
/// was where nothing is left open, or the points of time differ.
///   before  a fit of it, or of nearly the same recordings
Campaign with_free_faults(Campaign campaign, const FittedNull& before, const std::vector<Fault>& faults);

/// The likeliest that may stand beside the faults that were found, with its log Bayes factor as log_odds: it is another
/// one, matters, and no sensor is early. About as likely ones are its rivals.
std::optional<Fault> likeliest_of(const std::vector<SeenFault>& seen, const std::vector<Fault>& found);

}  // namespace leeway::gap
