#pragma once

#include <optional>

#include "gap/show/before_after.hpp"

namespace leeway::gap {

/// What ship.json says of a turning circle with more rudder than was recorded: the interval that the posterior of what
/// was fitted gives. Nothing where ship.json is the ship as it was given, where as much rudder was recorded, or where
/// the ship does not turn.
std::optional<BeyondRecorded> turning_beyond_recorded(const Answered& answered, const Explanation& explanation);

}  // namespace leeway::gap
