#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "core/scalar.hpp"
#include "forces/coefficient_list.hpp"
#include "forces/concepts.hpp"
#include "forces/motion.hpp"
#include "forces/particulars.hpp"
#include "forces/propeller_flow.hpp"
#include "io/json.hpp"
#include "recording/trajectory.hpp"

namespace leeway {

/// Kang et al. (2008), propeller of a single-propeller twin-rudder ship.
template <typename T>
struct KangPropellerCoefficients {
  double D_P;          ///< [m]
  double pitch_ratio;  ///< P/D
  double x_P;          ///< by L_pp, + forward
  double v_P_sign;     ///< v_P' = v' + v_P_sign x_P' r': -1 as coded by the model's authors, +1 at the propeller
  std::array<T, 3> K_T_ahead, K_T_astern;  ///< constant, J, J^2; for J >= 0 and J < 0
  std::array<T, 3> a, b, c, d;             ///< wake (a, b) and thrust deduction (c, d)

  template <typename U>
  KangPropellerCoefficients<U> cast() const {
    return {D_P,
            pitch_ratio,
            x_P,
            v_P_sign,
            cast_all<U>(K_T_ahead),
            cast_all<U>(K_T_astern),
            cast_all<U>(a),
            cast_all<U>(b),
            cast_all<U>(c),
            cast_all<U>(d)};
  }

  /// The actuators that act on it.
  static std::array<Channel, 1> channels() { return {Channel::n_p}; }
  /// Its keys in a ship's JSON, besides type and source.
  static KangPropellerCoefficients read(const io::JsonObject& json) {
    const double D_P = json.number("D_P_m", io::kPositive), pitch = json.number("pitch_ratio", io::kPositive);
    const double x_P = json.number("x_P", {-0.6, 0.6});
    const double sign = json.word("v_P", {"v - x_P r", "v + x_P r"}) == "v + x_P r" ? 1.0 : -1.0;
    return {D_P,
            pitch,
            x_P,
            sign,
            json.array<3>("K_T_ahead"),
            json.array<3>("K_T_astern"),
            json.array<3>("a"),
            json.array<3>("b"),
            json.array<3>("c"),
            json.array<3>("d")};
  }
};

/// Propeller in front of twin rudders. Defined for n >= 0; negative revolutions act as n = 0.
///   motion   (u, v_m [m/s], r [rad/s]) at midship, through the water;  n_P [1/s]
///   returns  X_P and the flow for the rudders; Y_P = N_P = 0
/// Wake and thrust deduction step at u = 0, as in the model: 1 - w_P and 1 - t_P are 1 for u <= 0. Thrust is formed as
/// n^2 K_T = k0 n^2 + k1 n u_P/D + k2 (u_P/D)^2, which has a limit at n = 0.
/// Source: Kang, Nagarajan, Hasegawa & Sano (2008), JMST 13, 207-222.
template <typename T>
struct KangPropeller {
  using Coefficients = KangPropellerCoefficients<double>;
  static constexpr bool drives_ship = true;
  static constexpr std::string_view group = "propeller", name = "kang-2008";
  static constexpr std::string_view reference = "Kang, Nagarajan, Hasegawa & Sano (2008), JMST 13, 207-222";
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
  /// All forces by this factor.
  void scale_force(const T& k) { scale_thrust(k); }
  /// What is known up to a factor: visit(name, log_sd, reference, scale), where scale(k) multiplies by k.
  template <typename Visit>
  void coefficients(const Visit& visit) {
    visit("propeller.K_T", 0.05, reference, [&](const T& k) { scale_thrust(k); });
    visit("propeller.K_T_J", 0.10, reference, factor_on(c.K_T_ahead[1]));
    visit("propeller.K_T_JJ", 0.10, reference, factor_on(c.K_T_ahead[2]));
    visit("propeller.K_T_astern", 0.10, reference, factor_on(c.K_T_astern));
    visit("propeller.1-w_P", 0.05, reference, factor_on(c.a));
    visit("propeller.a_1", 0.10, reference, factor_on(c.a[1]));
    visit("propeller.a_2", 0.10, reference, factor_on(c.a[2]));
    visit("propeller.b_0", 0.2, reference, factor_on(c.b[0]));
    visit("propeller.1-t_P", 0.05, reference, factor_on(c.c));
    visit("propeller.c_1", 0.10, reference, factor_on(c.c[1]));
    visit("propeller.c_2", 0.10, reference, factor_on(c.c[2]));
    visit("propeller.d_0", 0.2, reference, factor_on(c.d[0]));
  }

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

static_assert(HasThrust<KangPropeller<double>> && HasWake<KangPropeller<double>>);

}  // namespace leeway
