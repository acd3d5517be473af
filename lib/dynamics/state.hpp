#pragma once

#include "core/types.hpp"
#include "forces/actuators.hpp"

namespace leeway {

/// Pose and velocity of a ship.
template <typename T>
struct ShipState {
  Vec3<T> eta = Vec3<T>::Zero();  ///< (x0, y0 [m], psi [rad])
  Vec3<T> nu = Vec3<T>::Zero();   ///< (u, v_m [m/s], r [rad/s]) over ground
};

/// What acts on the ship at one instant.
template <typename T>
struct Inputs {
  Actuators<T> actuators;               ///< actual values
  Vec2<T> true_wind = Vec2<T>::Zero();  ///< from-vector in earth axes [m/s]: wind_from_vector() of core/wind.hpp
  double t_s = 0.0;                     ///< for effects that change with time
};

/// The inputs of one time step: at its start, its middle and its end.
template <typename T>
struct StepInputs {
  Inputs<T> start, middle, end;
};

}  // namespace leeway
