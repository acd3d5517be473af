#pragma once

#include "core/wind.hpp"
#include "effects/registry.hpp"
#include "forces/coefficient_factors.hpp"
#include "forces/inertia.hpp"
#include "forces/registry.hpp"
#include "forces/residual_network.hpp"

namespace leeway {

/// A ship: mass, force modules and effects. T is double, or an autodiff scalar for derivatives by state, actuators or,
/// after they were set, coefficients of the modules.
template <typename T>
struct Model {
  Inertia<T> inertia;
  ForceModules<T> modules;
  Effects<T> effects;
  std::shared_ptr<const ResidualNetwork> residual_network;  ///< nullptr: none

  /// With the effects of the ship. Throws InputError for a coefficient factor that the ship has not.
  explicit Model(const Ship& ship) : Model(ship, Effects<T>(ship)) {}
  /// With these effects, in place of the ship's.
  Model(const Ship& ship, Effects<T> other_effects)
      : inertia(ship.inertia, ship.particulars),
        modules(ship),
        effects(std::move(other_effects)),
        residual_network(ship.residual_network) {
    effects.change({ship, inertia, modules});
    multiply_coefficients(ship, inertia, modules);
  }

  /// (du/dt, dv_m/dt, dr/dt) at midship in water at rest, without what effects do during a run.
  ///   nu             (u, v_m [m/s], r [rad/s]) at midship
  ///   actuators      actual values
  ///   apparent_wind  in ship axes [m/s], pointing to where it comes from: apparent_wind() of core/wind.hpp
  Vec3<T> acceleration(const Vec3<T>& nu, const Actuators<T>& actuators, const Vec2<T>& apparent_wind) const {
    return inertia.acceleration(nu, modules.force(nu, actuators, apparent_wind));
  }
};

}  // namespace leeway
