#pragma once

#include <cmath>
#include <string_view>

#include "core/scalar.hpp"
#include "core/units.hpp"
#include "forces/motion.hpp"
#include "ship/actuators.hpp"
#include "ship/coefficients.hpp"

namespace leeway {

/// Bow or stern thruster whose effect changes with the ship's speed, Fr = |u| / sqrt(g L).
///   motion   (u, v_m [m/s], r [rad/s]) at midship, through the water
///   returns  (0, Y_T [N], N_T [N m]) at midship; n > 0 pushes to starboard. No force from |u| = u_max on: a step.
/// Source: Kobayashi (1988) in the form of the ensemble paper (Wakita, Akimoto & Maki).
template <typename T>
struct SideThruster {
  static constexpr std::string_view name = "kobayashi-1988";
  SideThrusterCoefficients<T> c;
  Particulars p;
  double Fr_per_speed;     ///< 1/sqrt(g L) [s/m]
  T inverse_u_c = T(0.0);  ///< a further loss exp(-(u/u_c)^2) [s/m]

  SideThruster(const SideThrusterCoefficients<double>& coefficients, const Particulars& particulars)
      : c(coefficients.cast<T>()), p(particulars), Fr_per_speed(1.0 / std::sqrt(kGravity_mps2 * p.L_pp)) {}

  Vec3<T> force(const Motion<T>& motion, const ActingActuators<T>& actuators) const {
    using std::abs, std::exp;
    const T& n = actuators[c.channel];
    const T abs_u = abs(motion.u);
    if (!(abs_u < T(c.u_max))) return Vec3<T>::Zero();
    const T Fr = abs_u * Fr_per_speed;
    const double D2 = c.D * c.D;
    T thrust = (p.rho * D2 * D2) * (n < T(0.0) ? c.K_T_negative : c.K_T_positive) * n * n;
    if (inverse_u_c > T(0.0)) thrust *= exp(-abs_u * abs_u * inverse_u_c * inverse_u_c);
    return {T(0.0), (1.0 + quadratic<T>(c.a_Y, Fr)) * thrust, (1.0 + quadratic<T>(c.a_N, Fr)) * thrust * c.x};
  }
};

}  // namespace leeway
