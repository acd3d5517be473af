#pragma once

#include <optional>
#include <vector>

#include "gap/locate/block_evidence.hpp"
#include "gap/locate/options.hpp"

/// Intervals in which accelerations are missing.
namespace leeway::gap {

struct FoundIntervals {
  std::vector<Interval> intervals;  ///< strongest first
  double strongest_p_value = 1.0;   ///< of those that are neither small nor called untrained
};

/// Scan over all runs of blocks within a stretch and all axes; p-values from the largest statistic of draws with the
/// same covariance; after each find what the interval explains is subtracted and the scan repeated. With an ensemble an
/// interval is called untrained where more than half of its points have an input beyond the training data, or the mean
/// acceleration that is missing on its axis is one that a further member could have (Student's t with as many degrees
/// of freedom as members less one, by the members' standard deviation there; probability above 0.1 %).
FoundIntervals intervals_of(const Campaign& campaign, const FittedNull& fit, BlockEvidence evidence,
                            const LocateOptions& options);

/// The interval in which a constant acceleration on all axes is likeliest, N(0, 1) in units of
/// reference_acceleration(), however likely that is; nothing where there is no block.
std::optional<Interval> likeliest_interval(const Campaign& campaign, const FittedNull& fit, std::size_t jobs);

/// The strongest interval that is neither small nor called untrained.
struct Strongest {
  double p_value = 1.0;
  std::optional<Interval> interval;  ///< where the p-value is below `false_alarm`
};
Strongest strongest_interval(const Campaign& campaign, const FittedNull& fit, const LocateOptions& options);

}  // namespace leeway::gap
