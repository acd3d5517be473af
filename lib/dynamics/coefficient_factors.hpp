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
/// multiplies them by its `coefficient_factors`.
template <typename T, typename Visit>
void for_each_coefficient(Inertia<T>& inertia, ForceModules<T>& modules, const Visit& visit) {
  inertia.coefficients(visit);
  modules.for_each([&](auto& module) { module.coefficients(visit); });
}

/// Multiplies coefficients by the factors of the ship. Throws InputError for a name that it does not have.
template <typename T>
void multiply_coefficients(const Ship& ship, Inertia<T>& inertia, ForceModules<T>& modules) {
  for (const CoefficientFactor& by : ship.coefficient_factors) {
    std::vector<std::string> known;
    for_each_coefficient(inertia, modules, [&](const char* name, double, std::string_view, const auto& scale) {
      known.emplace_back(name);
      if (by.name == name) scale(T(by.factor));
    });
    if (std::find(known.begin(), known.end(), by.name) == known.end())
      throw InputError(ship.file, 0, "/coefficient_factors/" + by.name,
                       fmt::format("not a coefficient of this ship; known: {}", fmt::join(known, ", ")));
  }
}

}  // namespace leeway
