#pragma once

#include "dynamics/coefficient_factors.hpp"
#include "dynamics/model.hpp"
#include "effects/registry.hpp"
#include "forces/force_modules.hpp"
#include "forces/inertia.hpp"

namespace leeway {

/// What a model consists of. Including this costs the compiler all modules and effects: model.cpp does, and tests.
template <typename T>
struct Model<T>::Parts {
  Inertia<T> inertia;
  ForceModules<T> modules;
  Effects<T> effects;
  std::shared_ptr<const ResidualNetwork> residual_network;  ///< nullptr: none
  std::vector<bool> moves;  ///< of each coefficient: its uncertainty is absolute; empty where that of none is

  /// With these effects, in place of the ship's.
  Parts(const Ship& ship, Effects<T> other_effects)
      : inertia(ship.inertia, ship.particulars),
        modules(*ship.modules, ship.particulars),
        effects(std::move(other_effects)),
        residual_network(ship.residual_network) {
    effects.change({ship, inertia, modules});
    leeway::change_coefficients(ship, inertia, modules);
    if (!ship.has_absolute_uncertainty()) return;
    for_each_coefficient(inertia, modules, [&](const char* name, double, std::string_view, const auto&) {
      moves.push_back(ship.is_absolute(name));
    });
  }
};

}  // namespace leeway
