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
#include "forces/source.hpp"
#include "io/json.hpp"
#include "recording/trajectory.hpp"

namespace leeway {

/// Propeller of the MMG standard method.
template <typename T>
struct StandardPropellerCoefficients {
  double D_P, x_P;                ///< as above
  double pitch_ratio;             ///< 0 where it is not given: for rudders that ask for it
  std::array<T, 3> K_T;           ///< n >= 0: constant, J, J^2
  T t_P, w_P0;                    ///< w_P0: on a straight run
  T C_1;                          ///< how fast the wake goes away with |beta_P|
  T C_2_negative, C_2_positive;   ///< (1 - w_P)/(1 - w_P0) far out, for beta_P < 0 and > 0
  bool is_reversible;             ///< whether the law for n < 0 is there
  std::array<T, 2> K_T_reversed;  ///< n < 0, J_s above J_s_reversed: constant, J_s
  T K_T_reversed_low;             ///< n < 0, J_s below
  double J_s_reversed;

  template <typename U>
  StandardPropellerCoefficients<U> cast() const {
    return {D_P,
            x_P,
            pitch_ratio,
            cast_all<U>(K_T),
            U(t_P),
            U(w_P0),
            U(C_1),
            U(C_2_negative),
            U(C_2_positive),
            is_reversible,
            cast_all<U>(K_T_reversed),
            U(K_T_reversed_low),
            J_s_reversed};
  }

  /// The actuators that act on it.
  static std::array<Channel, 1> channels() { return {Channel::n_p}; }
  /// Its keys in a ship's JSON, besides type and source.
  static StandardPropellerCoefficients read(const io::JsonObject& json) {
    StandardPropellerCoefficients result{};
    result.D_P = json.number("D_P_m", io::kPositive);
    result.x_P = json.number("x_P", {-0.6, 0.6});
    result.pitch_ratio = json.number_or("pitch_ratio", 0.0, io::kPositive);
    result.K_T = json.array<3>("K_T");
    result.t_P = json.number("t_P", {0.0, 1.0});
    result.w_P0 = json.number("w_P0", {0.0, 1.0});
    result.C_1 = json.number("C_1", io::kNotNegative);
    result.C_2_negative = json.number("C_2_negative", io::kPositive);
    result.C_2_positive = json.number("C_2_positive", io::kPositive);
    if (const auto reversed = json.object_if("reversed")) {
      require_source(*reversed);
      result.is_reversible = true;
      result.K_T_reversed = reversed->array<2>("K_T");
      result.K_T_reversed_low = reversed->number("K_T_low");
      result.J_s_reversed = reversed->number("J_s", {-10.0, 0.0});
      reversed->check_all_known();
    }
    return result;
  }
};

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
  using Coefficients = StandardPropellerCoefficients<double>;
  static constexpr bool drives_ship = true;
  static constexpr std::string_view group = "propeller", name = "mmg-standard";
  static constexpr std::string_view reference = "Yasukawa & Yoshimura (2015), JMST 20, 37-52";
  static constexpr std::string_view reference_of_reversed =
      "public simulator of Osaka University (NAOE-5thLab/mmg-1p1r-simulator), there attributed to Hachii";
  StandardPropellerCoefficients<T> c;
  Particulars p;
  double per_D_P;  ///< 1/D_P [1/m]

  StandardPropeller(const StandardPropellerCoefficients<double>& coefficients, const Particulars& particulars)
      : c(coefficients.cast<T>()), p(particulars), per_D_P(1.0 / c.D_P) {}

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
  void increase_wake(const T& dw) { c.w_P0 += dw; }
  /// w_P of straight ahead motion by this factor.
  void scale_wake(const T& k) { c.w_P0 *= k; }
  /// All forces by this factor.
  void scale_force(const T& k) { scale_thrust(k); }
  /// What is known up to a factor: visit(name, log_sd, reference, scale), where scale(k) multiplies by k.
  template <typename Visit>
  void coefficients(const Visit& visit) {
    visit("propeller.K_T", 0.05, reference, [&](const T& k) { scale_thrust(k); });
    visit("propeller.K_T_J", 0.10, reference, factor_on(c.K_T[1]));
    visit("propeller.K_T_JJ", 0.10, reference, factor_on(c.K_T[2]));
    visit("propeller.K_T_reversed", 0.10, reference_of_reversed, [&](const T& k) { scale_reversed_thrust(k); });
    visit("propeller.1-w_P", 0.05, reference, factor_on_rest(c.w_P0));
    visit("propeller.1-t_P", 0.05, reference, factor_on_rest(c.t_P));
    visit("propeller.C_1", 0.2, reference, factor_on(c.C_1));
    visit("propeller.C_2_negative", 0.10, reference, factor_on(c.C_2_negative));
    visit("propeller.C_2_positive", 0.10, reference, factor_on(c.C_2_positive));
  }

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

static_assert(HasThrust<StandardPropeller<double>> && HasWake<StandardPropeller<double>>);

}  // namespace leeway
