#pragma once

#include <cmath>
#include <string_view>

#include "core/scalar.hpp"
#include "forces/motion.hpp"
#include "forces/propeller_flow.hpp"
#include "ship/coefficients.hpp"

namespace leeway {

/// Propeller of the MMG standard method, with the wake in drift and yaw.
///   motion   (u, v_m [m/s], r [rad/s]) at midship, through the water;  n_P [1/s]
///   returns  X_P and the flow for the rudder; Y_P = N_P = 0
/// Where beta_P = beta - x_P' r' changes sign the wake changes its slope. Thrust is formed without dividing by n:
/// n^2 K_T = k0 n^2 + k1 n w + k2 w |w|, w = u_P/D_P.
/// Source: Yasukawa & Yoshimura (2015), JMST 20, 37-52, doi:10.1007/s00773-014-0293-y, made for u > 0 and n > 0. Ours:
///   u <= 0   there is no wake, 1 - w_P = 1; w |w| for w^2, so that a stopped propeller holds back a ship that goes
///            astern as it does one that goes ahead;
///   n < 0    X_P = rho D_P^4 [n^2 K_T,r + (1 - t_P) k2 w |w|] with K_T,r = a0 + a1 J_s, or a constant below a bound of
///            J_s = u/(n D_P): a law of the Esso Osaka model, here with the drag of the stopped propeller, so that
///            the force is continuous at n = 0. Without these numbers n < 0 acts as n = 0.
template <typename T>
struct StandardPropeller {
  static constexpr std::string_view name = "mmg-standard";
  StandardPropellerCoefficients<T> c;
  Particulars p;
  double per_D_P;  ///< 1/D_P [1/m]

  StandardPropeller(const StandardPropellerCoefficients<double>& coefficients, const Particulars& particulars)
      : c(coefficients.cast<T>()), p(particulars), per_D_P(1.0 / c.D_P) {}

  void scale_thrust(const T& k) {
    for (T& coefficient : c.K_T) coefficient *= k;
    for (T& coefficient : c.K_T_reversed) coefficient *= k;
    c.K_T_reversed_low *= k;
  }
  /// w_P of straight ahead motion plus this much.
  void increase_wake(const T& dw) { c.w_P0 += dw; }
  /// w_P of straight ahead motion by this factor.
  void scale_wake(const T& k) { c.w_P0 *= k; }

  PropellerFlow<T> flow(const Motion<T>& motion, const T& n_P) const {
    using std::abs;
    const T& u = motion.u;
    const T one_minus_w = u > T(0.0) ? wake(motion) : T(1.0);
    const T u_P = u * one_minus_w, w = u_P * per_D_P;
    const T drag = (1.0 - c.t_P) * c.K_T[2] * w * abs(w);  // of the stopped propeller

    const T n = n_P < T(0.0) && !c.is_reversible ? T(0.0) : n_P;
    T n2_K_T, thrust;  // by rho D_P^4; the thrust is what remains of it for the ship
    if (n < T(0.0)) {
      const T u_D = u * per_D_P;  // n J_s; J_s > J means u_D < J n, since n < 0
      n2_K_T = !(u_D > c.J_s_reversed * n) ? T(c.K_T_reversed[0] * n * n + c.K_T_reversed[1] * n * u_D)
                                           : T(c.K_T_reversed_low * n * n);
      thrust = n2_K_T + drag;
      n2_K_T += c.K_T[2] * w * abs(w);
    } else {
      n2_K_T = c.K_T[0] * n * n + c.K_T[1] * n * w + c.K_T[2] * w * abs(w);
      thrust = (1.0 - c.t_P) * n2_K_T;
    }
    const double D2 = c.D_P * c.D_P;
    const T J = n > T(0.0) || n < T(0.0) ? T(w / n) : T(0.0);
    return {Vec3<T>(p.rho * D2 * D2 * thrust, T(0.0), T(0.0)), n, one_minus_w, u_P, J, n2_K_T};
  }

 private:
  // 1 - w_P for u > 0.
  T wake(const Motion<T>& motion) const {
    using std::abs, std::exp, std::sqrt;
    if (motion.is_at_rest) return 1.0 - c.w_P0;
    const T beta_P = motion.beta - c.x_P * p.L_pp * motion.r * motion.per_U;
    const T& C_2 = beta_P < T(0.0) ? c.C_2_negative : c.C_2_positive;
    return (1.0 - c.w_P0) * (1.0 + (1.0 - exp(-c.C_1 * abs(beta_P))) * (C_2 - 1.0));
  }
};

}  // namespace leeway
