#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "forces/force_modules.hpp"
#include "forces/inertia.hpp"
#include "ship/ship.hpp"

namespace leeway {

/// Calls visit(name, log_sd, reference, scale) for each coefficient of a ship, or group of them, that is known up to a
/// factor: those that its modules list, always in the same order (forces/coefficient_list.hpp). A ship's JSON
/// multiplies them by its `coefficient_factors` and adds its `coefficient_shifts`.
template <typename T, typename Visit>
void for_each_coefficient(Inertia<T>& inertia, ForceModules<T>& modules, const Visit& visit) {
  inertia.coefficients(visit);
  modules.for_each([&](auto& module) { module.coefficients(visit); });
}

/// Multiplies coefficients by the factors of the ship, then adds its differences. Throws InputError for a name that it
/// does not have, and for a difference to a group of coefficients.
template <typename T>
void change_coefficients(const Ship& ship, Inertia<T>& inertia, ForceModules<T>& modules) {
  for (const CoefficientFactor& by : ship.coefficient_factors) {
    const std::string pointer = (by.shift != 0.0 ? "/coefficient_shifts/" : "/coefficient_factors/") + by.name;
    std::vector<std::string> known;
    for_each_coefficient(inertia, modules, [&]<typename S>(const char* name, double, std::string_view, const S& scale) {
      known.emplace_back(name);
      if (by.name != name) return;
      if (by.factor != 1.0) scale(T(by.factor));
      if (by.shift == 0.0) return;
      if constexpr (MovesBy<S, T>)
        scale.move(T(by.shift));
      else
        throw InputError(ship.file, 0, pointer, "is no single number: a factor can change it, a difference cannot");
    });
    if (std::find(known.begin(), known.end(), by.name) == known.end())
      throw InputError(ship.file, 0, pointer,
                       fmt::format("not a coefficient of this ship; known: {}", fmt::join(known, ", ")));
  }
}

}  // namespace leeway
