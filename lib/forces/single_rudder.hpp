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

/// One rudder behind one propeller.
template <typename T>
struct SingleRudderCoefficients {
  double A_R;  ///< [m^2]
  double aspect_ratio;
  double x_R;  ///< [m], + forward
  T t_R, a_H, x_H, l_R, epsilon, k_x, gamma_R_negative, gamma_R_positive, f_alpha;
  T k_reversed, k_hull_wake;  ///< slipstream factor and u^2 term behind a reversed propeller

  template <typename U>
  SingleRudderCoefficients<U> cast() const {
    return {A_R,
            aspect_ratio,
            x_R,
            U(t_R),
            U(a_H),
            U(x_H),
            U(l_R),
            U(epsilon),
            U(k_x),
            U(gamma_R_negative),
            U(gamma_R_positive),
            U(f_alpha),
            U(k_reversed),
            U(k_hull_wake)};
  }

  /// The actuators that act on it.
  static std::array<Channel, 1> channels() { return {Channel::delta}; }
  /// Its keys in a ship's JSON, besides type and source.
  static SingleRudderCoefficients read(const io::JsonObject& json) {
    const double A_R = json.number("A_R_m2", io::kPositive), x_R = json.number("x_R_m"),
                 t_R = json.number("t_R", {-1.0, 1.0});
    const double aspect_ratio = json.number("aspect_ratio", io::kPositive), k_x = json.number("k_x", io::kPositive);
    return {A_R,
            aspect_ratio,
            x_R,
            t_R,
            json.number("a_H"),
            json.number("x_H"),
            json.number("l_R"),
            json.number("epsilon", io::kPositive),
            k_x,
            json.number("gamma_R_negative"),
            json.number("gamma_R_positive"),
            json.number("f_alpha", io::kPositive),
            json.number("k_reversed", io::kNotNegative),
            json.number("k_hull_wake", io::kNotNegative)};
  }
};

/// One rudder behind one propeller, with the inflow behind a reversed propeller.
///   motion   (u, v_m [m/s], r [rad/s]) at midship, through the water
///   returns  (X_R [N], Y_R [N], N_R [N m]) at midship
/// gamma_R takes its side from the sway at the rudder, v_m + x_R r; at n < 0 the inflow changes its form with u.
/// Source: Yasukawa & Yoshimura (2015), JMST 20, 37-52 (MMG standard method); reversed propeller: as in the public
/// simulator of Osaka University (NAOE-5thLab/mmg-1p1r-simulator), there attributed to Kitagawa.
template <typename T>
struct SingleRudder {
  using Coefficients = SingleRudderCoefficients<double>;
  static constexpr std::string_view group = "rudder", name = "single";
  static constexpr std::string_view reference = "Yasukawa & Yoshimura (2015), JMST 20, 37-52";
  SingleRudderCoefficients<T> c;
  Particulars p;
  double D_P;  ///< of the propeller in front [m]
  double eta;  ///< share of the rudder's height in the slipstream
  NormalForceShape<T> shape;

  SingleRudder(const SingleRudderCoefficients<double>& coefficients, const Particulars& particulars,
               const PropellerSize& propeller)
      : c(coefficients.cast<T>()),
        p(particulars),
        D_P(propeller.D_P),
        eta(std::min(1.0, propeller.D_P / std::sqrt(c.A_R * c.aspect_ratio))) {}

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
    visit("rudder.k_x", 0.10, reference, factor_on(c.k_x));
    visit("rudder.gamma_R_negative", 0.2, reference, factor_on(c.gamma_R_negative));
    visit("rudder.gamma_R_positive", 0.2, reference, factor_on(c.gamma_R_positive));
    visit("rudder.gain_35deg", 0.2, NormalForceShape<T>::reference, factor_on(shape.k_35));
    visit("rudder.gain_90deg", 0.2, NormalForceShape<T>::reference, factor_on(shape.k_90));
  }

  Vec3<T> force(const Motion<T>& motion, const PropellerFlow<T>& flow, const ActingActuators<T>& actuators) const {
    using std::sqrt;
    const T u_R = inflow(motion.u, flow);
    const T gamma = motion.v + c.x_R * motion.r < T(0.0) ? c.gamma_R_negative : c.gamma_R_positive;
    const T v_R = -gamma * (motion.v + c.l_R * p.L_pp * motion.r);
    const T U_R2 = u_R * u_R + v_R * v_R;
    if (!(U_R2 > T(kAtRest_m2ps2))) return Vec3<T>::Zero();

    // U_R^2 sin(delta - atan2(v_R, u_R)), without the angle.
    const T &s = actuators.sine(Channel::delta), &k = actuators.cosine(Channel::delta);
    const T across = u_R * s - v_R * k;
    const T U_R = sqrt(U_R2);
    const T F_N = 0.5 * p.rho * c.A_R * c.f_alpha * U_R * across * shape.factor(u_R * k + v_R * s, across, U_R);
    return {-(1.0 - c.t_R) * F_N * s, -(1.0 + c.a_H) * F_N * k, -(c.x_R + c.a_H * c.x_H * p.L_pp) * F_N * k};
  }

 private:
  // Longitudinal flow at the rudder [m/s]; negative where it comes from astern.
  T inflow(const T& u, const PropellerFlow<T>& flow) const {
    using std::abs, std::sqrt;
    T b = c.epsilon * flow.u_P;
    if (!(flow.n < T(0.0)) && flow.n2_K_T > T(0.0)) {
      const T race = sqrt(flow.u_P * flow.u_P + 8.0 * flow.n2_K_T * (D_P * D_P / kPi));
      const T a = b + c.k_x * (race - flow.u_P);
      const T u_R2 = eta * a * a + (1.0 - eta) * b * b;
      return u_R2 > T(kAtRest_m2ps2) ? sqrt(u_R2) : T(0.0);
    }
    if (u < T(0.0)) return u;
    const T suction2 = 8.0 * abs(flow.n2_K_T) / kPi;
    if (!(suction2 > T(0.0))) return b;
    const T suction = c.k_reversed * D_P * sqrt(suction2);
    const T a = flow.n < T(0.0) ? T(b - suction) : T(b + suction);
    const T q = eta * (a < T(0.0) ? T(-a * a) : T(a * a)) + (1.0 - eta) * b * b - c.k_hull_wake * u * u;
    if (!(abs(q) > T(kAtRest_m2ps2))) return T(0.0);
    return q < T(0.0) ? T(-sqrt(-q)) : T(sqrt(q));
  }
};

static_assert(HasNormalForce<SingleRudder<double>> && HasFlowStraightening<SingleRudder<double>>);

}  // namespace leeway
