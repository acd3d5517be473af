#pragma once

#include "gap/null_fit.hpp"

namespace leeway::gap {

struct LocateOptions {
  double false_alarm = 0.01;      ///< of any interval where there is none
  double false_discovery = 0.05;  ///< share of wrong ones among the regimes
  std::size_t jobs = 1;
  std::uint64_t seed = 1;
};

/// Where the residual sits: which axes, which intervals, which frame and regime, which module.
struct Location {
  Located located;
  double scan_p_value = 1.0;  ///< of the strongest interval that is neither small nor called untrained
};

/// Everything is tested on accelerations added to the simulator, after the parameters (with twice their stated
/// uncertainty) have taken what they can:
///   intervals  scan over all runs of blocks within a stretch and all axes; p-values from the largest statistic of
///              draws with the same covariance; after each find the interval is taken out and the scan repeated;
///   frames     columns that are constant in a frame, by their Bayes factors;
///   regimes    a linear and a quadratic function of each variable, with Benjamini & Hochberg's false-discovery rate;
///   modules    each module's gain as a random walk over the blocks, by its Bayes factor.
/// With an ensemble there are no modules, and an interval is called untrained where more than half of its points have
/// an input beyond the training data, or the mean acceleration that is missing on its axis is one that a further member
/// could have (Student's t with as many degrees of freedom as members less one, by the members' standard deviation
/// there; probability above 0.1 %).
Location locate(const Campaign& campaign, const FittedNull& fit, const LocateOptions& options);

/// That interval alone.
struct Strongest {
  double p_value = 1.0;
  std::optional<Interval> interval;  ///< where the p-value is below `false_alarm`
};
Strongest strongest_interval(const Campaign& campaign, const FittedNull& fit, const LocateOptions& options);

/// The smoothed residual along each recording.
std::vector<Residual> residuals(const Campaign& campaign, const FittedNull& fit);

}  // namespace leeway::gap
