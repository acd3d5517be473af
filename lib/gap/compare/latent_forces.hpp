#pragma once

#include <vector>

#include "gap/fit/null_fit.hpp"
#include "gap/result/latent_force.hpp"

namespace leeway::gap {

/// What of each kind acts beside a fit, the likeliest kind first: by one linear step, averaged over sizes, lengths,
/// periods and axes; each with the model error that is left beside it. A force that depends on
///   place    is a Gaussian process over the positions of the tracks, in earth axes
///   heading  has a few harmonics of it
///   period   is an oscillation whose phase is its own in each recording
///   memory   follows squares of past motions and orders, or rings after them, less what they are now
///   states   is a Gaussian process over one quantity that the ship does or is told, or two
/// Kinds of which the recordings have no column are not in the list; what depends on time alone is an interval.
std::vector<LatentForce> latent_forces(const Campaign& campaign, const FittedNull& fit, std::size_t jobs);

}  // namespace leeway::gap
