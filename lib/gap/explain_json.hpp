#pragma once

#include "gap/explain.hpp"
#include "io/json.hpp"

namespace leeway::gap {

/// The contents of report.json but for `provenance`; keys and units in docs/gap-explain.md. A number that is not finite
/// becomes null.
io::Json to_json(const Explanation& explanation);

/// The ship's JSON with the effects added, as it stands in ship.json: what was there stays as it is.
///   of       the contents of the ship's file
///   effects  Explanation::effects, or those of one recording
io::Json ship_with(io::Json of, const std::vector<EffectEntry>& effects);

}  // namespace leeway::gap
