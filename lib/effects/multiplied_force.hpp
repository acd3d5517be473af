#pragma once

#include <string_view>

namespace leeway {

/// The effect that does nothing but multiply a force of the standard model: "resistance", "thrust" or "rudder force";
/// empty: none.
constexpr std::string_view effect_that_multiplies(std::string_view force) {
  return force == "resistance"     ? "fouling"
         : force == "thrust"       ? "thrust-loss"
         : force == "rudder force" ? "rudder-effectiveness"
                                   : "";
}

}  // namespace leeway
