#pragma once

#include <cmath>
#include <string_view>

#include "core/scalar.hpp"
#include "forces/motion.hpp"
#include "forces/propeller_flow.hpp"
#include "ship/coefficients.hpp"

namespace leeway {

/// Propeller in front of twin rudders. Defined for n >= 0; negative revolutions act as n = 0.
///   motion   (u, v_m [m/s], r [rad/s]) at midship, through the water;  n_P [1/s]
///   returns  X_P and the flow for the rudders; Y_P = N_P = 0
/// Wake and thrust deduction step at u = 0, as in the model: 1 - w_P and 1 - t_P are 1 for u <= 0. Thrust is formed as
/// n^2 K_T = k0 n^2 + k1 n u_P/D + k2 (u_P/D)^2, which has a limit at n = 0.
/// Source: Kang, Nagarajan, Hasegawa & Sano (2008), JMST 13, 207-222.
template <typename T>
struct KangPropeller {
  static constexpr std::string_view name = "kang-2008";
  KangPropellerCoefficients<T> c;
  Particulars p;

  double per_D_P;  ///< 1/D_P [1/m]

  KangPropeller(const KangPropellerCoefficients<double>& coefficients, const Particulars& particulars)
      : c(coefficients.cast<T>()), p(particulars), per_D_P(1.0 / c.D_P) {}

  void scale_thrust(const T& k) {
    for (T& coefficient : c.K_T_ahead) coefficient *= k;
    for (T& coefficient : c.K_T_astern) coefficient *= k;
  }
  /// w_P of straight ahead motion plus this much.
  void increase_wake(const T& dw) { c.a[0] -= dw; }
  /// w_P of straight ahead motion by this factor.
  void scale_wake(const T& k) { c.a = {1.0 - k * (1.0 - c.a[0]), k * c.a[1], k * c.a[2]}; }

  PropellerFlow<T> flow(const Motion<T>& motion, const T& n_P) const {
    const T& u = motion.u;
    const T n = n_P > T(kStopped_rps) ? n_P : T(0.0);
    const bool is_ahead = u > T(0.0) && !motion.is_at_rest;

    const T per_nD = n > T(0.0) ? T(1.0 / (n * c.D_P)) : T(0.0);
    T v_P(0.0), one_minus_w(1.0);
    if (is_ahead) {
      v_P = (motion.v + c.v_P_sign * c.x_P * p.L_pp * motion.r) * motion.per_U;
      // At n = 0 J_s is infinite, and the wake at its lower limit.
      if (n > T(0.0))
        one_minus_w = limited<T>(quadratic<T>(c.a, u * per_nD) + oblique(c.b, v_P), 0.0, 1.0);
      else
        one_minus_w = T(0.0);
    }
    const T u_P = u * one_minus_w;
    const T J = n > T(0.0) ? T(u_P * per_nD) : T(u < T(0.0) ? -kFarAstern : 0.0);
    const T one_minus_t = is_ahead ? limited<T>(quadratic<T>(c.c, J) + oblique(c.d, v_P), 0.0, 1.0) : T(1.0);

    const std::array<T, 3>& k = u < T(0.0) ? c.K_T_astern : c.K_T_ahead;
    const T w = u_P * per_D_P;
    const T n2_K_T = k[0] * n * n + k[1] * n * w + k[2] * w * w;
    const double D2 = c.D_P * c.D_P;
    const T X = one_minus_t * (p.rho * D2 * D2) * n2_K_T;
    return {Vec3<T>(X, T(0.0), T(0.0)), n, one_minus_w, u_P, J, n2_K_T};
  }

 private:
  // An actuator approaches 0 exponentially and never arrives; below this J_s would overflow and mean nothing.
  static constexpr double kStopped_rps = 1e-9;
  static constexpr double kFarAstern = 100.0;  // beyond all limits of the polynomials in J

  // What drift and yaw take off the wake fraction and the thrust deduction.
  static T oblique(const std::array<T, 3>& k, const T& v_P) {
    using std::abs;
    const T s = v_P + k[2] * v_P * abs(v_P);
    return k[0] * (k[1] * v_P + s * s);
  }
};

}  // namespace leeway
