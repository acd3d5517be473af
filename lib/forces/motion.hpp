#pragma once

#include <cmath>

#include "core/scalar.hpp"
#include "core/types.hpp"

namespace leeway {

/// The ship's motion through the water as the force modules see it, with what several of them need.
template <typename T>
struct Motion {
  T u, v, r;  ///< surge, sway at midship [m/s], yaw rate [rad/s]
  T U2, U;    ///< U^2, speed [m/s]
  T per_U;    ///< 1/U [s/m]; 0 at rest, as U and beta are
  T beta;     ///< drift angle atan2(-v, u) [rad]
  bool is_at_rest;

  /// nu: a vector of three.
  template <typename Derived>
  Motion(const Eigen::MatrixBase<Derived>& nu)
      : u(nu(0)), v(nu(1)), r(nu(2)), U2(u * u + v * v), U(0.0), per_U(0.0), beta(0.0) {
    using std::abs, std::atan, std::atan2, std::sqrt;
    is_at_rest = !(U2 > T(kAtRest_m2ps2));
    if (is_at_rest) return;
    U = sqrt(U2);
    per_U = 1.0 / U;
    // Below 45 deg by atan, which costs half of atan2.
    beta = abs(v) < u ? T(atan(-v / u)) : T(atan2(T(-v), u));
  }
  Motion(const T& surge, const T& sway, const T& yaw_rate) : Motion(Vec3<T>(surge, sway, yaw_rate)) {}
};

}  // namespace leeway
