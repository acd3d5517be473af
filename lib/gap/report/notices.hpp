#pragma once

#include "gap/filter/campaign.hpp"
#include "gap/result/findings.hpp"
#include "recording/origin.hpp"

namespace leeway::gap {

/// What a reader has to know of recordings and fit, besides what was found.
void add_notices(Findings& findings, const Campaign& campaign);
/// Of an ensemble as the simulator.
void add_ensemble_notices(const EnsembleSimulator& simulator, Findings& findings);
/// That positions are not counted from where the recordings count.
std::string counted_from(const Origin& origin);
/// That these may be recordings of another ship.
std::string another_ship(const Ship& ship);

}  // namespace leeway::gap
