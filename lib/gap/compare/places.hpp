#pragma once

#include <string>
#include <vector>

#include "gap/detect/screen.hpp"
#include "gap/filter/campaign.hpp"
#include "gap/result/findings.hpp"

/// Effects that are bound to a place.
namespace leeway::gap {

/// Where such an effect (a bank, a fender, a mooring line) may be, about the tracks: walls beside them, walls that the
/// hull touches, or anchors.
///   events  when something acts: there the directions of walls are tried more finely
std::vector<FreeEffect::Choice> places_of(const std::string& effect, const Campaign& campaign,
                                          const std::vector<Interval>& events);

/// Of walls in nearly the same direction keeps the one of the largest expected gain.
///   starts  sorted, the best first
void keep_apart(std::vector<Start>& starts);

/// Puts lines that are taut at any length and those with slack in turn: neighbors on a grid of anchors gain nearly
/// alike, and a fit frees no slack.
///   starts  sorted, the best first
void take_turns(std::vector<Start>& starts);

}  // namespace leeway::gap
