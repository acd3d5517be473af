#pragma once

#include "gap/fit/null_fit.hpp"
#include "gap/locate/intervals.hpp"
#include "gap/locate/options.hpp"
#include "gap/locate/residuals.hpp"

namespace leeway::gap {

/// Where the residual sits: which axes, which intervals, which frame and regime, which module.
struct Location {
  Located located;
  double scan_p_value = 1.0;  ///< of the strongest interval that is neither small nor called untrained
};

/// Everything is tested on accelerations added to the simulator, after the parameters (with twice their stated
/// uncertainty) have taken what they can: intervals (intervals.hpp), modules (walking_gains.hpp), frames (frames.hpp),
/// regimes (regimes.hpp) and the line of action (line_of_action.hpp). With an ensemble there are no modules.
Location locate(const Campaign& campaign, const FittedNull& fit, const LocateOptions& options);

}  // namespace leeway::gap
