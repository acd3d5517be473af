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

/// Propeller of the Esso Osaka model, ahead and astern.
template <typename T>
struct FourQuadrantPropellerCoefficients {
  double D_P, pitch_ratio, x_P;   ///< as above
  std::array<T, 3> K_T;           ///< n >= 0: constant, J, J^2
  T t_P;                          ///< n >= 0
  std::array<T, 3> w_P;           ///< constant, |v_P'|, v_P'^2
  std::array<T, 2> K_T_reversed;  ///< n < 0, J_s above J_s_reversed: constant, J_s
  T K_T_reversed_low;             ///< n < 0, J_s below
  double J_s_reversed;
  std::array<T, 3> Y_backing, N_backing;  ///< n >= 0, u < 0: constant, J_s, J_s^2; by (n P)^2
  std::array<double, 2> J_s_walk;         ///< n < 0: bounds of the three ranges
  std::array<T, 2> Y_walk_low, Y_walk_middle, N_walk_low, N_walk_middle;  ///< constant, J_s; by (n D_P)^2
  T Y_walk_high, N_walk_high;

  template <typename U>
  FourQuadrantPropellerCoefficients<U> cast() const {
    return {D_P,
            pitch_ratio,
            x_P,
            cast_all<U>(K_T),
            U(t_P),
            cast_all<U>(w_P),
            cast_all<U>(K_T_reversed),
            U(K_T_reversed_low),
            J_s_reversed,
            cast_all<U>(Y_backing),
            cast_all<U>(N_backing),
            J_s_walk,
            cast_all<U>(Y_walk_low),
            cast_all<U>(Y_walk_middle),
            cast_all<U>(N_walk_low),
            cast_all<U>(N_walk_middle),
            U(Y_walk_high),
            U(N_walk_high)};
  }

  /// The actuators that act on it.
  static std::array<Channel, 1> channels() { return {Channel::n_p}; }
  /// Its keys in a ship's JSON, besides type and source.
  static FourQuadrantPropellerCoefficients read(const io::JsonObject& json) {
    const FourQuadrantPropellerCoefficients result{json.number("D_P_m", io::kPositive),
                                                   json.number("pitch_ratio", io::kPositive),
                                                   json.number("x_P", {-0.6, 0.6}),
                                                   json.array<3>("K_T"),
                                                   json.number("t_P", {0.0, 1.0}),
                                                   json.array<3>("w_P"),
                                                   json.array<2>("K_T_reversed"),
                                                   json.number("K_T_reversed_low"),
                                                   json.number("J_s_reversed", {-10.0, 0.0}),
                                                   json.array<3>("Y_backing"),
                                                   json.array<3>("N_backing"),
                                                   json.array<2>("J_s_walk"),
                                                   json.array<2>("Y_walk_low"),
                                                   json.array<2>("Y_walk_middle"),
                                                   json.array<2>("N_walk_low"),
                                                   json.array<2>("N_walk_middle"),
                                                   json.number("Y_walk_high"),
                                                   json.number("N_walk_high")};
    if (!(result.J_s_walk[0] < result.J_s_walk[1])) json.fail("J_s_walk", "expected two increasing numbers");
    return result;
  }
};

/// Propeller in all four quadrants of (u, n), with the side force and moment of a reversed propeller or a ship that
/// goes astern.
///   motion   (u, v_m [m/s], r [rad/s]) at midship, through the water;  n_P [1/s]
///   returns  (X_P, Y_P, N_P) and the flow for the rudder
/// J_s = u/(n D_P). n = 0 counts as the limit from n > 0: at n = 0 the two fits do not meet exactly. All terms are
/// formed without dividing by n. Source: equations and numbers of the public simulator of Osaka University
/// (NAOE-5thLab/mmg-1p1r-simulator), which attributes n < 0 to Hachii and the side force to Ueno.
template <typename T>
struct FourQuadrantPropeller {
  using Coefficients = FourQuadrantPropellerCoefficients<double>;
  static constexpr bool drives_ship = true;
  static constexpr std::string_view group = "propeller", name = "four-quadrant";
  static constexpr std::string_view reference =
      "public simulator of Osaka University (NAOE-5thLab/mmg-1p1r-simulator c54ef80)";
  FourQuadrantPropellerCoefficients<T> c;
  Particulars p;

  FourQuadrantPropeller(const FourQuadrantPropellerCoefficients<double>& coefficients, const Particulars& particulars)
      : c(coefficients.cast<T>()), p(particulars) {}

  void scale_thrust(const T& k) {
    for (T& coefficient : c.K_T) coefficient *= k;
    scale_reversed_thrust(k);
  }
  /// That of n < 0.
  void scale_reversed_thrust(const T& k) {
    for (T& coefficient : c.K_T_reversed) coefficient *= k;
    c.K_T_reversed_low *= k;
  }
  /// w_P of straight ahead motion plus this much.
  void increase_wake(const T& dw) { c.w_P[0] += dw; }
  /// w_P of straight ahead motion by this factor.
  void scale_wake(const T& k) { c.w_P[0] *= k; }
  /// All forces by this factor.
  void scale_force(const T& k) { scale_thrust(k); }
  /// What is known up to a factor: visit(name, log_sd, reference, scale), where scale(k) multiplies by k.
  template <typename Visit>
  void coefficients(const Visit& visit) {
    visit("propeller.K_T", 0.05, reference, [&](const T& k) { scale_thrust(k); });
    visit("propeller.K_T_J", 0.10, reference, factor_on(c.K_T[1]));
    visit("propeller.K_T_JJ", 0.10, reference, factor_on(c.K_T[2]));
    visit("propeller.K_T_reversed", 0.10, reference, [&](const T& k) { scale_reversed_thrust(k); });
    visit("propeller.1-w_P", 0.05, reference, factor_on_rest(c.w_P[0]));
    visit("propeller.1-t_P", 0.05, reference, factor_on_rest(c.t_P));
    visit("propeller.w_P_v", 0.2, reference, factor_on(c.w_P[1]));
    visit("propeller.w_P_vv", 0.2, reference, factor_on(c.w_P[2]));
  }

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

static_assert(HasThrust<FourQuadrantPropeller<double>> && HasWake<FourQuadrantPropeller<double>>);

}  // namespace leeway
