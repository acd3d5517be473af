#pragma once

#include "gap/explain.hpp"
#include "io/json.hpp"

namespace leeway::gap {

/// The contents of report.json but for `provenance`; keys and units in docs/gap-explain.md. A number that is not finite
/// becomes null.
io::Json to_json(const Explanation& explanation);

/// The file that holds the ship as it sails in one recording, where recordings differ.
std::string ship_file(const std::string& recording);

/// The ship's JSON with the effects added, as it stands in ship.json: what was there stays as it is.
///   of       the contents of the ship's file
///   effects  Explanation::effects, or those of one recording
///   network  Explanation::residual_network; nullptr: none. It takes the place of one that is there.
io::Json ship_with(io::Json of, const std::vector<EffectEntry>& effects, const ResidualNetwork* network = nullptr);

}  // namespace leeway::gap
