#pragma once

#include "gap/result/findings.hpp"
#include "io/json.hpp"

namespace leeway::gap {

/// null where it is not finite.
io::Json number(double value);

/// How far each coefficient moved, by its name.
io::Json to_json(const std::vector<ParameterShift>& shifts);

/// The contents of locate.json but for `provenance`; keys and units in docs/gap-locate.md. A number that is not finite
/// becomes null.
io::Json to_json(const Findings& findings);

}  // namespace leeway::gap
