#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <string_view>

#include "core/types.hpp"
#include "effects/description.hpp"
#include "effects/rudder_response.hpp"
#include "forces/force_modules.hpp"
#include "forces/inertia.hpp"
#include "ship/ship.hpp"

/// Physics that a model can lack. Each effect is one header: what it is, its formula, its parameters with their priors,
/// and the code. An effect does what it has members for; registry.hpp calls them:
///
///   void change(ModelParts<T>&)                       coefficients, once, when the model is made
///   void act(Actuators<T>&) const                     what acts instead of what the recording says
///   Vec2<T> wind(const Situation<T>&) const           added to the true wind, from-vector in earth axes [m/s]
///   WaterMotion<T> water(const Situation<T>&) const   added to the motion of the water at the ship's place
///   Vec3<T> force(const Situation<T>&) const          added at midship (X [N], Y [N], N [N m])
///   void slow(RudderResponse&) const                  the rudders follow late what is recorded of them; with T =
///   double
///                                                     alone: it is done to the recorded angles before a step
///
/// At zero strength an effect changes nothing, to the last bit.
namespace leeway {

/// What effects may change when the model is made.
template <typename T>
struct ModelParts {
  const Ship& ship;
  Inertia<T>& inertia;
  ForceModules<T>& modules;
};

/// What effects may look at during a run: water() at time and pose alone, wind() also at the velocity over ground and
/// the recorded wind, force() at all. Frames and signs as in docs/conventions.md.
template <typename T>
struct Situation {
  double t_s;
  Vec3<T> eta;            ///< (x0, y0 [m], psi [rad])
  T cos_psi, sin_psi;     ///< of the heading
  Vec3<T> nu_ground;      ///< (u, v_m [m/s], r [rad/s])
  Vec3<T> nu_water;       ///< the same through the water; r less the water's turn
  Vec2<T> recorded_wind;  ///< true wind as the recording has it, from-vector in earth axes [m/s]; 0: none is recorded
  const Actuators<T>* actuators = nullptr;  ///< as they act
  Vec2<T> to_ship(const Vec2<T>& earth) const {
    return {cos_psi * earth(0) + sin_psi * earth(1), -sin_psi * earth(0) + cos_psi * earth(1)};
  }
  Vec2<T> to_earth(const Vec2<T>& ship) const {
    return {cos_psi * ship(0) - sin_psi * ship(1), sin_psi * ship(0) + cos_psi * ship(1)};
  }
};

/// The water about the ship, in earth axes: its velocity V [m/s], how that changes with time at a fixed place [m/s^2],
/// and from place to place, dV_i/dx_j [1/s].
template <typename T>
struct WaterMotion {
  Vec2<T> velocity = Vec2<T>::Zero(), rate = Vec2<T>::Zero();
  Mat2<T> gradient = Mat2<T>::Zero();

  /// dV/dt along the path of a ship that moves over ground with this velocity in earth axes [m/s^2].
  Vec2<T> along_path(const Vec2<T>& over_ground) const { return rate + gradient * over_ground; }
  /// The yaw rate that a ship has in water at rest where the cross flow changes along it as it does here [rad/s]:
  /// e_y' R' (dV/dp) R e_x, to be taken off r in the hydrodynamic forces. Source: Thomasson & Woolsey (2013), IEEE J.
  /// Oceanic Engineering 38, put the flow's gradient into the angular rate of the viscous terms.
  T turn(const Situation<T>& at) const {
    const T &c = at.cos_psi, &s = at.sin_psi;
    return c * (gradient(1, 0) * c + gradient(1, 1) * s) - s * (gradient(0, 0) * c + gradient(0, 1) * s);
  }
};

}  // namespace leeway
