#pragma once

#include <vector>

#include "core/random.hpp"
#include "gap/compare/fitted.hpp"
#include "gap/filter/campaign.hpp"

namespace leeway::gap {

/// A campaign like the recorded one, as it would be recorded again if a hypothesis were true: coefficients and effects
/// drawn from what the fit leaves open of them, model error, wind error and measurement noise of its levels, events
/// where it has them, correlated noise where the channels have it; samples at the same times, holes in the same places.
///
/// Each stretch starts at its smoothed state with the recorded orders. Rudders have a helmsman's corrections towards
/// the recorded course on top (a share of course and rate error), or held courses would drift into turns; the corrected
/// angles are what is recorded. Throws NumericalError where the ship runs away.
///   campaign  the recordings that the hypothesis was fitted to
std::vector<Trajectory> simulated_recordings(const Campaign& campaign, const Fitted& fitted, RandomStream random);

}  // namespace leeway::gap
