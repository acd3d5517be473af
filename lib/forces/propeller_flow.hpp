#pragma once

#include "core/types.hpp"

namespace leeway {

/// Of the propeller in front of a rudder.
struct PropellerSize {
  double D_P = 0.0;          ///< [m]
  double pitch_ratio = 0.0;  ///< 0 where it is not given
};

/// What a propeller does to the ship and to the rudder behind it.
template <typename T>
struct PropellerFlow {
  Vec3<T> force;    ///< (X_P [N], Y_P [N], N_P [N m]) at midship
  T n;              ///< revolutions [1/s]
  T one_minus_w_P;  ///< 1 - w_P
  T u_P;            ///< inflow u (1 - w_P) [m/s]
  T J;              ///< advance ratio u_P/(n D_P); where n = 0, a number beyond every limit that depends on it
  T n2_K_T;         ///< n^2 K_T [1/s^2]: finite at n = 0, where K_T is not
};

}  // namespace leeway
