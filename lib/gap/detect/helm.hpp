#pragma once

#include <optional>
#include <vector>

#include "gap/filter/campaign.hpp"
#include "gap/filter/state_space.hpp"

namespace leeway::gap {

/// The law of a stretch's rudders, and how much more they know of the ship than its recordings do. Whoever steers by
/// heading and yaw rate sees the ship herself: where the rudders' mean angle is
///   per_heading psi + per_rate r + offset + e,
/// e is how well they tell what she does, and the filter's uncertainty of the same sum how well the sensors do. The law
/// is a regression on smoothed states, whose errors have nothing to do with what is smoothed, so that nothing is
/// attenuated. Points where the rudders are at the largest or smallest angle of the recording count only where they
/// hardly move at all: at its limit an autopilot follows nothing.
///   smoothed  with nothing missing, the rudders as inputs
/// `ahead` is the variance of the filter's uncertainty by that of e: near 0 where rudders are moved by the clock, or to
/// turn; about 1 and more where an autopilot keeps a course. Nothing without rudders.
struct Helm {
  HelmLaw law;
  double ahead = 0.0;
};
std::optional<Helm> helm_of(const Campaign& campaign, const Stretch& stretch, const Smoothed& smoothed);

/// The campaign with the law of each stretch in which rudders tell more of the ship than the sensors do and oppose her
/// turns; nothing where there is none.
///   smoothed  of each stretch, with nothing missing, the rudders as inputs
std::optional<Campaign> with_helms(const Campaign& campaign, const std::vector<Smoothed>& smoothed);

/// Whether a stretch is straight by itself: its rudders stay where they are, and neither sway nor yaw is told from
/// none. Such a ship answers to nothing. That she begins without drift and without yaw nobody knows beforehand, and a
/// file that lets both die away sooner makes it likelier that they are never seen: coefficients of hull and rudders
/// would seem off.
///   smoothed  with nothing missing
bool is_straight(const Campaign& campaign, const Stretch& stretch, const Smoothed& smoothed);

}  // namespace leeway::gap
