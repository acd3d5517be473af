#pragma once

#include "gap/fit/null_fit.hpp"

namespace leeway::gap {

/// Root mean square of the accelerations along the paths (m/s^2, m/s^2, rad/s^2).
Vec3<double> typical_acceleration(const std::vector<LinearStretch>& stretches);

/// Renews the scales of the model error: blocks whose mean square is far above that of most. The median knows what most
/// blocks are, also where a few have made sigma_w large.
void find_events(FittedNull& fit, const Campaign& campaign);

/// Neighboring blocks in which the model error of one axis is larger.
struct Event {
  std::size_t stretch, begin, end;  ///< points
  Eigen::Index axis;
  double log_prior;  ///< to begin in this block and axis among all, and to go on from block to block as likely as not
};
std::vector<Event> events_of(const FittedNull& fit, const Campaign& campaign);
/// Gives the blocks of an event the usual model error, and the prior without it.
void leave_out(const Event& event, FittedNull& fit);

/// Measurements that the others contradict. Judged by what all other measurements say, before and after: e of the
/// smoothed state has the variance R - P, which is e of the prediction without this measurement, in its own sd (de Jong
/// 1988). Outliers make that sd too large; the median knows better.
///   returns for each stretch a copy without them, or nothing where it has none; they are counted in the fit's report
std::vector<std::shared_ptr<const Stretch>> without_outliers(FittedNull& fit);

}  // namespace leeway::gap
