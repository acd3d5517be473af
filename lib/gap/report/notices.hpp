#pragma once

#include "gap/filter/campaign.hpp"
#include "gap/result/findings.hpp"

namespace leeway::gap {

/// What a reader has to know of recordings and fit, besides what was found.
void add_notices(Findings& findings, const Campaign& campaign);
/// Of an ensemble as the simulator.
void add_ensemble_notices(const EnsembleSimulator& simulator, Findings& findings);
/// That these may be recordings of another ship.
std::string another_ship(const Ship& ship);

}  // namespace leeway::gap
