#pragma once

#include <cmath>
#include <string_view>

#include "core/scalar.hpp"
#include "forces/motion.hpp"
#include "forces/propeller_flow.hpp"
#include "ship/coefficients.hpp"

namespace leeway {

/// Propeller in all four quadrants of (u, n), with the side force and moment of a reversed propeller or a ship that
/// goes astern.
///   motion   (u, v_m [m/s], r [rad/s]) at midship, through the water;  n_P [1/s]
///   returns  (X_P, Y_P, N_P) and the flow for the rudder
/// J_s = u/(n D_P). n = 0 counts as the limit from n > 0: at n = 0 the two fits do not meet exactly. All terms are
/// formed without dividing by n. Source: equations and numbers of the public simulator of Osaka University
/// (NAOE-5thLab/mmg-1p1r-simulator), which attributes n < 0 to Hachii and the side force to Ueno.
template <typename T>
struct FourQuadrantPropeller {
  static constexpr std::string_view name = "four-quadrant";
  FourQuadrantPropellerCoefficients<T> c;
  Particulars p;

  FourQuadrantPropeller(const FourQuadrantPropellerCoefficients<double>& coefficients, const Particulars& particulars)
      : c(coefficients.cast<T>()), p(particulars) {}

  void scale_thrust(const T& k) {
    for (T& coefficient : c.K_T) coefficient *= k;
    for (T& coefficient : c.K_T_reversed) coefficient *= k;
    c.K_T_reversed_low *= k;
  }
  /// w_P of straight ahead motion plus this much.
  void increase_wake(const T& dw) { c.w_P[0] += dw; }
  /// w_P of straight ahead motion by this factor.
  void scale_wake(const T& k) { c.w_P[0] *= k; }

  PropellerFlow<T> flow(const Motion<T>& motion, const T& n) const {
    using std::abs;
    const T& u = motion.u;

    T one_minus_w(1.0);
    if (u > T(0.0) && !motion.is_at_rest) {
      const T v_P = abs((motion.v + c.x_P * p.L_pp * motion.r) * motion.per_U);
      one_minus_w = limited<T>(1.0 - quadratic<T>(c.w_P, v_P), 0.0, 1.0);
    }
    const T u_P = u * one_minus_w;
    const double D = c.D_P, q_X = p.rho * D * D * D * D;
    const double q_Y = 0.5 * p.rho * p.L_pp * p.d, q_N = q_Y * p.L_pp;
    const bool is_reversed = n < T(0.0);
    const T u_D = u / D;  // n J_s

    T n2_K_T, X, Y(0.0), N(0.0);
    if (!is_reversed) {
      const T w = u_P / D;
      n2_K_T = c.K_T[0] * n * n + c.K_T[1] * n * w + c.K_T[2] * w * w;
      X = (1.0 - c.t_P) * q_X * n2_K_T;
      if (u < T(0.0)) {
        const double P2 = c.pitch_ratio * c.pitch_ratio * D * D;
        Y = q_Y * P2 * (c.Y_backing[0] * n * n + c.Y_backing[1] * n * u_D + c.Y_backing[2] * u_D * u_D);
        N = q_N * P2 * (c.N_backing[0] * n * n + c.N_backing[1] * n * u_D + c.N_backing[2] * u_D * u_D);
      }
    } else {
      // J_s > J means u/D < J n, since n < 0.
      n2_K_T = !(u_D > c.J_s_reversed * n) ? T(c.K_T_reversed[0] * n * n + c.K_T_reversed[1] * n * u_D)
                                           : T(c.K_T_reversed_low * n * n);
      X = q_X * n2_K_T;
      const double D2 = D * D;
      if (u_D > c.J_s_walk[0] * n) {
        Y = q_Y * D2 * (c.Y_walk_low[0] * n * n + c.Y_walk_low[1] * n * u_D);
        N = q_N * D2 * (c.N_walk_low[0] * n * n + c.N_walk_low[1] * n * u_D);
      } else if (u_D < c.J_s_walk[1] * n) {
        Y = q_Y * D2 * c.Y_walk_high * n * n;
        N = q_N * D2 * c.N_walk_high * n * n;
      } else {
        Y = q_Y * D2 * (c.Y_walk_middle[0] * n * n + c.Y_walk_middle[1] * n * u_D);
        N = q_N * D2 * (c.N_walk_middle[0] * n * n + c.N_walk_middle[1] * n * u_D);
      }
    }
    const T J = n > T(0.0) || n < T(0.0) ? T(u_P / (n * D)) : T(0.0);
    return {Vec3<T>(X, Y, N), n, one_minus_w, u_P, J, n2_K_T};
  }
};

}  // namespace leeway
