#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "core/scalar.hpp"
#include "core/units.hpp"
#include "forces/actuators.hpp"
#include "forces/coefficient_list.hpp"
#include "forces/concepts.hpp"
#include "forces/motion.hpp"
#include "forces/particulars.hpp"
#include "io/json.hpp"

namespace leeway {

/// Side thruster after Kobayashi (1988).
template <typename T>
struct SideThrusterCoefficients {
  Channel channel;            ///< n_bt or n_st
  double D, x;                ///< [m]
  T K_T_positive;             ///< n >= 0: force to starboard
  T K_T_negative;             ///< n < 0: a negative number
  std::array<T, 3> a_Y, a_N;  ///< constant, Fr, Fr^2
  double u_max;               ///< [m/s], no force from here on

  template <typename U>
  SideThrusterCoefficients<U> cast() const {
    return {channel, D, x, U(K_T_positive), U(K_T_negative), cast_all<U>(a_Y), cast_all<U>(a_N), u_max};
  }

  /// The actuators that act on it.
  std::array<Channel, 1> channels() const { return {channel}; }
  /// Its keys in a ship's JSON, besides type and source.
  static SideThrusterCoefficients read(const io::JsonObject& json) {
    const Channel channel = json.word("channel", {"n_bt", "n_st"}) == "n_bt" ? Channel::n_bt : Channel::n_st;
    return {channel,
            json.number("D_m", io::kPositive),
            json.number("x_m"),
            json.number("K_T_positive", io::kNotNegative),
            json.number("K_T_negative", {-10.0, 0.0}),
            json.array<3>("a_Y"),
            json.array<3>("a_N"),
            json.number("u_max_mps", io::kPositive)};
  }
};

/// Bow or stern thruster whose effect changes with the ship's speed, Fr = |u| / sqrt(g L).
///   motion   (u, v_m [m/s], r [rad/s]) at midship, through the water
///   returns  (0, Y_T [N], N_T [N m]) at midship; n > 0 pushes to starboard. No force from |u| = u_max on: a step.
/// Source: Kobayashi (1988) in the form of the ensemble paper (Wakita, Akimoto & Maki).
template <typename T>
struct SideThruster {
  using Coefficients = SideThrusterCoefficients<double>;
  static constexpr std::string_view group = "thruster", name = "kobayashi-1988";
  static constexpr std::string_view reference = "Kobayashi (1988), in the form of the ensemble paper";
  SideThrusterCoefficients<T> c;
  Particulars p;
  double Fr_per_speed;     ///< 1/sqrt(g L) [s/m]
  T inverse_u_c = T(0.0);  ///< a further loss exp(-(u/u_c)^2) [s/m]

  SideThruster(const SideThrusterCoefficients<double>& coefficients, const Particulars& particulars)
      : c(coefficients.cast<T>()), p(particulars), Fr_per_speed(1.0 / std::sqrt(kGravity_mps2 * p.L_pp)) {}

  void scale_thrust(const T& k) {
    c.K_T_positive *= k;
    c.K_T_negative *= k;
  }
  /// All forces by this factor.
  void scale_force(const T& k) { scale_thrust(k); }
  /// What is known up to a factor: visit(name, log_sd, reference, scale), where scale(k) multiplies by k.
  template <typename Visit>
  void coefficients(const Visit& visit) {
    const bool is_bow = c.channel == Channel::n_bt;
    visit(is_bow ? "thruster.K_T_bow_positive" : "thruster.K_T_stern_positive", 0.10, reference,
          factor_on(c.K_T_positive));
    visit(is_bow ? "thruster.K_T_bow_negative" : "thruster.K_T_stern_negative", 0.10, reference,
          factor_on(c.K_T_negative));
    visit(is_bow ? "thruster.a_Y_bow" : "thruster.a_Y_stern", 0.2, reference, factor_on(c.a_Y));
    visit(is_bow ? "thruster.a_N_bow" : "thruster.a_N_stern", 0.2, reference, factor_on(c.a_N));
  }

  Vec3<T> force(const Motion<T>& motion, const ActingActuators<T>& actuators) const {
    using std::abs, std::exp;
    const T& n = actuators[c.channel];
    const T abs_u = abs(motion.u);
    if (!(abs_u < T(c.u_max))) return Vec3<T>::Zero();
    const T Fr = abs_u * Fr_per_speed;
    const double D2 = c.D * c.D;
    T thrust = (p.rho * D2 * D2) * (n < T(0.0) ? c.K_T_negative : c.K_T_positive) * n * n;
    if (inverse_u_c > T(0.0)) thrust *= exp(-abs_u * abs_u * inverse_u_c * inverse_u_c);
    return {T(0.0), (1.0 + quadratic<T>(c.a_Y, Fr)) * thrust, (1.0 + quadratic<T>(c.a_N, Fr)) * thrust * c.x};
  }
};

static_assert(HasSideThrust<SideThruster<double>> && HasSpeedLoss<SideThruster<double>>);

}  // namespace leeway
