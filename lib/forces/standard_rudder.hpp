#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "core/scalar.hpp"
#include "core/units.hpp"
#include "forces/actuators.hpp"
#include "forces/coefficient_list.hpp"
#include "forces/concepts.hpp"
#include "forces/motion.hpp"
#include "forces/normal_force_shape.hpp"
#include "forces/particulars.hpp"
#include "forces/propeller_flow.hpp"
#include "io/json.hpp"

namespace leeway {

/// Rudder of the MMG standard method.
template <typename T>
struct StandardRudderCoefficients {
  double A_R;  ///< [m^2]
  double H_R;  ///< height [m]
  double x_R;  ///< [m], + forward
  T t_R, a_H, x_H, l_R, epsilon, kappa, gamma_R_negative, gamma_R_positive, f_alpha;
  T k_reversed;  ///< share of a race that goes forward, felt on the propeller's suction side

  template <typename U>
  StandardRudderCoefficients<U> cast() const {
    return {A_R,
            H_R,
            x_R,
            U(t_R),
            U(a_H),
            U(x_H),
            U(l_R),
            U(epsilon),
            U(kappa),
            U(gamma_R_negative),
            U(gamma_R_positive),
            U(f_alpha),
            U(k_reversed)};
  }

  /// The actuators that act on it.
  static std::array<Channel, 1> channels() { return {Channel::delta}; }
  /// Its keys in a ship's JSON, besides type and source.
  static StandardRudderCoefficients read(const io::JsonObject& json) {
    const double A_R = json.number("A_R_m2", io::kPositive), x_R = json.number("x_R_m"),
                 t_R = json.number("t_R", {-1.0, 1.0});
    return {A_R,
            json.number("H_R_m", io::kPositive),
            x_R,
            t_R,
            json.number("a_H"),
            json.number("x_H"),
            json.number("l_R"),
            json.number("epsilon", io::kPositive),
            json.number("kappa", io::kNotNegative),
            json.number("gamma_R_negative"),
            json.number("gamma_R_positive"),
            json.number("f_alpha", io::kPositive),
            json.number("k_reversed", io::kNotNegative)};
  }
};

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
  using Coefficients = StandardRudderCoefficients<double>;
  static constexpr std::string_view group = "rudder", name = "mmg-standard";
  static constexpr std::string_view reference = "Yasukawa & Yoshimura (2015), JMST 20, 37-52";
  StandardRudderCoefficients<T> c;
  Particulars p;
  double D_P;  ///< of the propeller in front [m]
  double eta;  ///< share of the rudder's height in the slipstream
  NormalForceShape<T> shape;

  StandardRudder(const StandardRudderCoefficients<double>& coefficients, const Particulars& particulars,
                 const PropellerSize& propeller)
      : c(coefficients.cast<T>()), p(particulars), D_P(propeller.D_P), eta(std::min(1.0, propeller.D_P / c.H_R)) {}

  /// The normal force by a factor; of the two sides' the port one's belongs to the only rudder.
  void scale_normal_force(const T& k, const T&) { c.f_alpha *= k; }
  void scale_flow_straightening(const T& k) {
    c.gamma_R_negative *= k;
    c.gamma_R_positive *= k;
  }
  /// All forces by this factor.
  void scale_force(const T& k) { scale_normal_force(k, k); }
  /// What is known up to a factor: visit(name, log_sd, reference, scale), where scale(k) multiplies by k.
  template <typename Visit>
  void coefficients(const Visit& visit) {
    visit("rudder.1-t_R", 0.05, reference, factor_on_rest(c.t_R));
    visit("rudder.gain", 0.10, reference, factor_on(c.f_alpha));
    visit("rudder.a_H", 0.2, reference, factor_on(c.a_H));
    visit("rudder.x_H", 0.10, reference, factor_on(c.x_H));
    visit("rudder.l_R", 0.15, reference, factor_on(c.l_R));
    visit("rudder.epsilon", 0.05, reference, factor_on(c.epsilon));
    visit("rudder.kappa", 0.10, reference, factor_on(c.kappa));
    visit("rudder.gamma_R_negative", 0.2, reference, factor_on(c.gamma_R_negative));
    visit("rudder.gamma_R_positive", 0.2, reference, factor_on(c.gamma_R_positive));
    visit("rudder.gain_35deg", 0.2, NormalForceShape<T>::reference, factor_on(shape.k_35));
    visit("rudder.gain_90deg", 0.2, NormalForceShape<T>::reference, factor_on(shape.k_90));
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

static_assert(HasNormalForce<StandardRudder<double>> && HasFlowStraightening<StandardRudder<double>>);

}  // namespace leeway
