#pragma once

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/scalar.hpp"
#include "core/units.hpp"
#include "forces/motion.hpp"
#include "forces/normal_force_shape.hpp"
#include "forces/propeller_flow.hpp"
#include "ship/actuators.hpp"
#include "ship/coefficients.hpp"

namespace leeway {

/// Rudder of the MMG standard method, behind one propeller.
///   motion   (u, v_m [m/s], r [rad/s]) at midship, through the water
///   returns  (X_R [N], Y_R [N], N_R [N m]) at midship
/// v_R = U gamma_R beta_R with beta_R = beta - l_R' r'; gamma_R takes its side from the sign of beta_R, where v_R = 0.
/// Source: Yasukawa & Yoshimura (2015), JMST 20, 37-52, doi:10.1007/s00773-014-0293-y, made for u > 0 and a propeller
/// that pushes ahead. Ours:
///   u < 0      beta is counted from the stern, atan2(-v_m, -u), so that v_R is continuous at |beta| = 90 deg; w_R = 0;
///   all n, u   u_R^2 and the squares inside keep their signs, so that the flow may come from astern. The race
///              sqrt(u_P^2 + 8 K_T n^2 D_P^2/pi) is +-sqrt|u_P |u_P| + 8 K_T n^2 D_P^2/pi|; where it goes forward, the
///              rudder stands on the propeller's suction side and feels k_reversed of it in place of epsilon kappa.
/// For u > 0 and K_T > 0 these are the printed equations.
template <typename T>
struct StandardRudder {
  static constexpr std::string_view name = "mmg-standard";
  StandardRudderCoefficients<T> c;
  Particulars p;
  double D_P;  ///< of the propeller in front [m]
  double eta;  ///< share of the rudder's height in the slipstream
  NormalForceShape<T> shape;

  StandardRudder(const StandardRudderCoefficients<double>& coefficients, const Particulars& particulars, double D_P_m)
      : c(coefficients.cast<T>()), p(particulars), D_P(D_P_m), eta(std::min(1.0, D_P_m / c.H_R)) {}

  /// The normal force by a factor; of the two sides' the port one's belongs to the only rudder.
  void scale_normal_force(const T& k, const T&) { c.f_alpha *= k; }
  void scale_flow_straightening(const T& k) {
    c.gamma_R_negative *= k;
    c.gamma_R_positive *= k;
  }

  Vec3<T> force(const Motion<T>& motion, const PropellerFlow<T>& flow, const ActingActuators<T>& actuators) const {
    using std::abs, std::sqrt;
    T beta = motion.beta;
    if (motion.u < T(0.0)) beta = (beta < T(0.0) ? -kPi : kPi) - beta;  // from the stern
    const T U_beta_R = motion.U * beta - c.l_R * p.L_pp * motion.r;
    const T v_R = (U_beta_R < T(0.0) ? c.gamma_R_negative : c.gamma_R_positive) * U_beta_R;
    const T u_R_squared = squared_inflow(flow), u_R = root(u_R_squared);
    const T U_R2 = abs(u_R_squared) + v_R * v_R;
    if (!(U_R2 > T(kAtRest_m2ps2))) return Vec3<T>::Zero();

    // U_R^2 sin(delta - atan2(v_R, u_R)), without the angle.
    const T &s = actuators.sine(Channel::delta), &k = actuators.cosine(Channel::delta);
    const T across = u_R * s - v_R * k;
    const T U_R = sqrt(U_R2);
    const T F_N = 0.5 * p.rho * c.A_R * c.f_alpha * U_R * across * shape.factor(u_R * k + v_R * s, across, U_R);
    return {-(1.0 - c.t_R) * F_N * s, -(1.0 + c.a_H) * F_N * k, -(c.x_R + c.a_H * c.x_H * p.L_pp) * F_N * k};
  }

 private:
  static T squared(const T& x) { return x < T(0.0) ? T(-x * x) : T(x * x); }  // with the sign of x

  static T root(const T& x) {  // with the sign of x
    using std::abs, std::sqrt;
    if (!(abs(x) > T(kAtRest_m2ps2))) return T(0.0);
    return x < T(0.0) ? T(-sqrt(-x)) : T(sqrt(x));
  }

  // What a propeller's race of speed w brings to the rudder's place.
  T felt(const T& w) const { return (w < T(0.0) ? c.k_reversed : T(c.epsilon * c.kappa)) * w; }

  // Longitudinal flow at the rudder, squared with its sign [m^2/s^2]; negative where it comes from astern.
  T squared_inflow(const PropellerFlow<T>& flow) const {
    const T b = flow.u_P < T(0.0) ? flow.u_P : T(c.epsilon * flow.u_P);
    const T race = root(squared(flow.u_P) + 8.0 * flow.n2_K_T * (D_P * D_P / kPi));
    return eta * squared(b + felt(race) - felt(flow.u_P)) + (1.0 - eta) * squared(b);
  }
};

}  // namespace leeway
