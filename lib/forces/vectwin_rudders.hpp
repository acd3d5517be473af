#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
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

/// VecTwin rudders after Kang et al. (2008); the regression's polynomials stand in forces/vectwin_rudders.hpp.
template <typename T>
struct VectwinRuddersCoefficients {
  double A_R;  ///< of each rudder [m^2]
  double aspect_ratio;
  double x_R;  ///< [m], + forward
  T t_R, k_x;

  template <typename U>
  VectwinRuddersCoefficients<U> cast() const {
    return {A_R, aspect_ratio, x_R, U(t_R), U(k_x)};
  }

  /// The actuators that act on it.
  static std::array<Channel, 2> channels() { return {Channel::delta_p, Channel::delta_s}; }
  /// Its keys in a ship's JSON, besides type and source.
  static VectwinRuddersCoefficients read(const io::JsonObject& json) {
    const double A_R = json.number("A_R_m2", io::kPositive), x_R = json.number("x_R_m"),
                 t_R = json.number("t_R", {-1.0, 1.0});
    const double aspect_ratio = json.number("aspect_ratio", io::kPositive);
    return {A_R, aspect_ratio, x_R, t_R, json.number("k_x", io::kPositive)};
  }
};

/// A pair of high-lift rudders behind one propeller. s: starboard, p: port; delta > 0 turns the bow to starboard.
///   motion   (u, v_m [m/s], r [rad/s]) at midship, through the water
///   returns  (X_R [N], Y_R [N], N_R [N m]) at midship
/// Steps that belong to the model: the flow straightening and l_R change with the signs of the drift angle, the
/// effective rudder angle and r; C_N steps by 1.8 % at 37.5 deg; there is no slipstream without thrust.
/// Source: Kang, Nagarajan, Hasegawa & Sano (2008), JMST 13, 207-222; regression numbers of its VLCC model as found in
/// public research code (S0mirun/LDA_PP 9258b27), except x_H, where that code puts a_H by mistake. The model gives the
/// normal forces measured by Kang et al. within 0.01 kgf.
template <typename T>
struct VectwinRudders {
  using Coefficients = VectwinRuddersCoefficients<double>;
  static constexpr std::string_view group = "rudder", name = "vectwin-kang-2008";
  static constexpr std::string_view reference = "Kang, Nagarajan, Hasegawa & Sano (2008), JMST 13, 207-222";
  VectwinRuddersCoefficients<T> c;
  Particulars p;
  double D_P;  ///< of the propeller in front [m]
  double D_P_by_pitch;
  double eta;                                                 ///< share of the rudder's height in the slipstream
  T k_port = T(1.0), k_starboard = T(1.0), k_gamma = T(1.0);  ///< on the normal forces, on the flow straightening
  T k_interference = T(1.0);                                  ///< on the angles that one rudder takes off the other's
  T k_a_H = T(1.0), k_x_H = T(1.0), k_l_R = T(1.0);           ///< on the regressed a_H, x_H and l_R
  std::optional<T> k_interaction;  ///< further loss at |sin(delta_s - delta_p)| = 1: effects/vectwin_interaction.hpp
  NormalForceShape<T> shape;

  VectwinRudders(const VectwinRuddersCoefficients<double>& coefficients, const Particulars& particulars,
                 const PropellerSize& propeller)
      : c(coefficients.cast<T>()),
        p(particulars),
        D_P(propeller.D_P),
        D_P_by_pitch(propeller.D_P / (propeller.D_P * propeller.pitch_ratio)),
        eta(std::min(1.0, propeller.D_P / std::sqrt(c.A_R * c.aspect_ratio))) {}

  void scale_normal_force(const T& port, const T& starboard) {
    k_port *= port;
    k_starboard *= starboard;
  }
  void scale_flow_straightening(const T& k) { k_gamma *= k; }
  /// All forces by this factor.
  void scale_force(const T& k) { scale_normal_force(k, k); }
  /// What is known up to a factor: visit(name, log_sd, reference, scale), where scale(k) multiplies by k.
  template <typename Visit>
  void coefficients(const Visit& visit) {
    visit("rudder.1-t_R", 0.05, reference, factor_on_rest(c.t_R));
    visit("rudder.gain_port", 0.10, reference, factor_on(k_port));
    visit("rudder.gain_starboard", 0.10, reference, factor_on(k_starboard));
    visit("rudder.k_x", 0.10, reference, factor_on(c.k_x));
    visit("rudder.gamma_R", 0.2, reference, factor_on(k_gamma));
    visit("rudder.interference", 0.2, reference, factor_on(k_interference));
    visit("rudder.a_H", 0.2, reference, factor_on(k_a_H));
    visit("rudder.x_H", 0.10, reference, factor_on(k_x_H));
    visit("rudder.l_R", 0.15, reference, factor_on(k_l_R));
    visit("rudder.gain_35deg", 0.2, NormalForceShape<T>::reference, factor_on(shape.k_35));
    visit("rudder.gain_90deg", 0.2, NormalForceShape<T>::reference, factor_on(shape.k_90));
  }

  /// Normal forces [N] of the two rudders.
  struct NormalForces {
    T port, starboard;
  };

  Vec3<T> force(const Motion<T>& motion, const PropellerFlow<T>& flow, const ActingActuators<T>& actuators) const {
    NormalForces F = normal_forces(motion, flow, actuators[Channel::delta_p], actuators[Channel::delta_s]);
    T X_lost(0.0);
    if (k_interaction) {
      using std::abs;
      const T lost = *k_interaction * abs(actuators.sine(Channel::delta_s) * actuators.cosine(Channel::delta_p) -
                                          actuators.cosine(Channel::delta_s) * actuators.sine(Channel::delta_p));
      const T race = 0.7 * (D_P / D_P_by_pitch) * (flow.n > T(0.0) ? flow.n : T(0.0));
      F.port *= 1.0 - lost;
      F.starboard *= 1.0 - lost;
      X_lost = lost * (0.5 * p.rho * c.A_R) * race * race;
    }
    const T& J = flow.J;
    const T a_H = k_a_H * limited<T>(0.016 + (1.69 - 1.179 * J) * J, 0.016, 0.60556);
    const T x_H = k_x_H * p.L_pp * limited<T>(-0.159 + (-1.065 + 1.01 * J) * J, -0.4344, -0.159);
    const T across = F.starboard * actuators.cosine(Channel::delta_s) + F.port * actuators.cosine(Channel::delta_p);
    const T along = F.starboard * actuators.sine(Channel::delta_s) + F.port * actuators.sine(Channel::delta_p);
    return {-(1.0 - c.t_R) * along - X_lost, -(1.0 + a_H) * across, -(c.x_R + a_H * x_H) * across};
  }

  NormalForces normal_forces(const Motion<T>& motion, const PropellerFlow<T>& flow, const T& delta_p,
                             const T& delta_s) const {
    using std::abs, std::cos, std::sqrt;
    const T &u = motion.u, &v_m = motion.v, &r = motion.r;

    // Slip ratio.
    const T s = flow.n > T(0.0) ? limited<T>(1.0 - flow.J * D_P_by_pitch, 0.0, 1.2) : T(1.2);
    const T s2 = s * s;

    // Angles from the hydrodynamic neutral ones, then less the influence of the other rudder.
    const T delta_s1 = delta_s - (0.015 - 0.164 * s), delta_p1 = delta_p - (-0.008 + 0.114 * s);
    const T C1s = 0.088 - 0.11 * s + 0.162 * s2, C2s = 0.129 - 0.259 * s + 0.343 * s2;
    const T C2p = -0.18 + 0.085 * s - 0.226 * s2;
    T delta_sp = (C1s + C2s * delta_p) * delta_p, delta_ps = (0.14 + C2p * delta_s) * delta_s;
    if (delta_s1 > T(0.0)) delta_sp *= abs(cos(delta_s1));
    if (delta_p1 < T(0.0)) delta_ps *= abs(cos(delta_p1));
    const T delta_s2 = delta_s1 - k_interference * delta_sp, delta_p2 = delta_p1 - k_interference * delta_ps;

    // Slipstream, slowed by the other rudder.
    T u_Rs(0.0), u_Rp(0.0);
    if (flow.n2_K_T > T(0.0)) {
      const T race = c.k_x * (sqrt(flow.u_P * flow.u_P + 8.0 * flow.n2_K_T * (D_P * D_P / kPi)) - flow.u_P);
      const T w_s = 0.665 + (0.19 + (0.051 - 0.095 * delta_s) * delta_s) * delta_s;  // 1 - w_R
      const T w_p = 0.665 + (-0.19 + (0.051 + 0.095 * delta_p) * delta_p) * delta_p;
      T f_s(1.0), f_p(1.0);
      if (delta_s2 > T(0.0)) {
        const T f1 = 1.791 - 1.861 * s + 1.348 * s2, f2 = -2.489 + 5.243 * s - 4.159 * s2;
        const T f3 = 1.399 - 3.239 * s + 2.598 * s2;
        f_s = f1 + (f2 + f3 * delta_s2) * delta_s2;
        if (f_s > T(1.0)) f_s = T(1.0);
      }
      if (delta_p2 < T(0.0)) {
        const T f2 = 0.343 - 0.151 * s + 0.657 * s2, f3 = 0.011 + 0.176 * s + 0.38 * s2;
        f_p = 1.0 + (f2 + f3 * delta_p2) * delta_p2;
        if (f_p > T(1.0)) f_p = T(1.0);
      }
      u_Rs = f_s * slipstream(w_s * u, race);
      u_Rp = f_p * slipstream(w_p * u, race);
    }

    // Flow straightening by quadrant of drift angle and rudder angle; zero at rest.
    const T gamma_s = k_gamma * straightening(kStarboard, motion.beta, delta_s2);
    const T gamma_p = k_gamma * straightening(kPort, motion.beta, delta_p2);
    const bool to_starboard = !(r < T(0.0));
    const T l_s = k_l_R * c.x_R * (to_starboard ? (delta_s2 < T(0.0) ? 0.2 : 0.0) : (delta_s2 < T(0.0) ? 0.4 : 0.6));
    const T l_p = k_l_R * c.x_R * (to_starboard ? (delta_p2 < T(0.0) ? 0.6 : 0.4) : (delta_p2 < T(0.0) ? 0.0 : 0.2));
    return {k_port * normal_force(u_Rp, T(-gamma_p * v_m - l_p * r), delta_p2),
            k_starboard * normal_force(u_Rs, T(-gamma_s * v_m - l_s * r), delta_s2)};
  }

 private:
  struct Straightening {
    double r1, r2, r3, r4, cap;
  };
  // beta >= 0 and delta < 0; beta < 0, delta < 0; beta >= 0, delta >= 0; beta < 0, delta >= 0.
  static constexpr Straightening kStarboard[] = {{0.615, -1.068, -7.823, 11.07, 0.8},
                                                 {2.66, -3.611, 2.971, -2.602, 0.8},
                                                 {-0.864, 2.719, 15.43, -44.18, 0.8},
                                                 {2.781, -3.55, -3.787, 4.834, 1.0}};
  static constexpr Straightening kPort[] = {{6.256, -12.3, 8.759, -18.38, 1.0},
                                            {10.07, -30.62, 13.36, -43.29, 0.8},
                                            {6.559, -13.77, -8.238, 20.25, 0.8},
                                            {9.064, -24.76, -4.256, 25.31, 0.8}};

  static T straightening(const Straightening (&table)[4], const T& beta, const T& delta) {
    using std::abs;
    const Straightening& k = table[(delta < T(0.0) ? 0 : 2) + (beta < T(0.0) ? 1 : 0)];
    const T b = abs(beta);
    return limited<T>((k.r1 + k.r2 * b + (k.r3 + k.r4 * b) * delta) * b, 0.0, k.cap);
  }

  // eps sqrt(eta (u_P + kappa (race - u_P))^2 + (1 - eta) u_P^2) with eps u_P = (1 - w_R) u and eps kappa = k_x:
  // nothing is divided by 1 - w_P. `race` is k_x times the gain of speed.
  T slipstream(const T& eps_u_P, const T& race) const {
    using std::sqrt;
    const T inside = eps_u_P + race;
    const T u_R2 = eta * inside * inside + (1.0 - eta) * eps_u_P * eps_u_P;
    return u_R2 > T(kAtRest_m2ps2) ? sqrt(u_R2) : T(0.0);
  }

  T normal_force(const T& u_R, const T& v_R, const T& delta) const {
    using std::abs, std::atan2, std::cos, std::sin, std::sqrt;
    const T U_R2 = u_R * u_R + v_R * v_R;
    if (!(U_R2 > T(kAtRest_m2ps2))) return T(0.0);
    // C_N = 2.6252 sin(alpha) up to 37.5 deg, alpha = delta - atan2(v_R, u_R): there, the angle itself is not needed.
    constexpr double kCos2 = 0.62940952255126037;  // cos^2 37.5 deg
    const T s = sin(delta), k = cos(delta), U_R = sqrt(U_R2);
    const T along = u_R * k + v_R * s, across = u_R * s - v_R * k;  // U_R cos(alpha), U_R sin(alpha)
    T C_N_U_R2;
    if (along > T(0.0) && along * along >= kCos2 * U_R2) {
      C_N_U_R2 = 2.6252 * U_R * across;
    } else {
      const T alpha = delta - atan2(v_R, u_R), a = abs(alpha);
      C_N_U_R2 = (-0.8449 * a * a + 2.0621 * a + 0.6387) * U_R2;
      if (alpha < T(0.0)) C_N_U_R2 = -C_N_U_R2;
    }
    return 0.5 * p.rho * c.A_R * C_N_U_R2 * shape.factor(along, across, U_R);
  }
};

static_assert(HasNormalForce<VectwinRudders<double>> && HasFlowStraightening<VectwinRudders<double>> &&
              HasTwinRudders<VectwinRudders<double>>);

}  // namespace leeway
