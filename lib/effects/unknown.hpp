#pragma once

#include <cmath>

#include "core/units.hpp"
#include "effects/effect.hpp"

namespace leeway {

/// A dimensionless coefficient that is normally distributed about nothing.
constexpr EffectParameter unknown_term(std::string_view name, std::string_view of, double sd) {
  return {name,
          of,
          0.0,
          0.0,
          -kUnbounded,
          kUnbounded,
          normal(0.0, sd, -100.0 * sd, 100.0 * sd),
          normal(0.0, sd, -100.0 * sd, 100.0 * sd)};
}

template <typename T>
struct Unknown {
  static constexpr EffectInfo info{
      .name = "unknown",
      .number = "I",
      .sentence = "Something acts that the catalogue does not hold; these terms stand for it where it was recorded.",
      .phrase = "something that the catalogue does not hold",
      .formula =
          "X = 1/2 rho L d sum X_i t_i, Y = 1/2 rho L d sum Y_i t_i, N = 1/2 rho L^2 d sum N_i t_i; t_i [m^2/s^2] of "
          "u, "
          "v through the water, w = r L, p = n_p d, b = n_bt d, sin delta (mean of two rudders), sqrt(g L)",
      .source =
          "products that units and the symmetry between port and starboard allow (X even; Y and N odd); ours. The "
          "priors "
          "are about the same force each, 0.05 of 1/2 rho L d U^2 at Froude number 0.1",
      .look_alikes = "whatever is not yet known",
      .separating_maneuver = "the maneuvers in which the terms that were found are largest",
      .search = SearchStart::terms,
  };
  static constexpr std::array<EffectParameter, 38> parameters{{
      unknown_term("X_u", "of u sqrt(g L)", 0.005),
      unknown_term("X_sqrt_u", "of sign(u) |u|^(1/2) (g L)^(3/4)", 0.0015),
      unknown_term("X_uu", "of u |u|", 0.02),
      unknown_term("X_vv", "of v^2", 0.05),
      unknown_term("X_rr", "of w^2", 0.05),
      unknown_term("X_vr", "of v w", 0.05),
      unknown_term("X_un", "of u p", 0.005),
      unknown_term("X_nn", "of p |p|", 0.001),
      unknown_term("X_dd", "of u^2 sin^2 delta", 0.05),
      unknown_term("X_ndd", "of p^2 sin^2 delta", 0.002),
      unknown_term("X_bb", "of b^2", 0.0002),
      unknown_term("X_ub", "of u |b|", 0.003),
      unknown_term("Y_v", "of v sqrt(g L)", 0.005),
      unknown_term("Y_r", "of w sqrt(g L)", 0.005),
      unknown_term("Y_uv", "of u v", 0.05),
      unknown_term("Y_ur", "of u w", 0.05),
      unknown_term("Y_vv", "of v |v|", 0.05),
      unknown_term("Y_rr", "of w |w|", 0.05),
      unknown_term("Y_vr", "of |v| w", 0.05),
      unknown_term("Y_d", "of u^2 sin delta", 0.05),
      unknown_term("Y_nd", "of p^2 sin delta", 0.002),
      unknown_term("Y_vn", "of v p", 0.005),
      unknown_term("Y_rn", "of w p", 0.005),
      unknown_term("Y_bb", "of b |b|", 0.0002),
      unknown_term("Y_ub", "of |u| b", 0.003),
      unknown_term("N_v", "of v sqrt(g L)", 0.0015),
      unknown_term("N_r", "of w sqrt(g L)", 0.0015),
      unknown_term("N_uv", "of u v", 0.015),
      unknown_term("N_ur", "of u w", 0.015),
      unknown_term("N_vv", "of v |v|", 0.015),
      unknown_term("N_rr", "of w |w|", 0.015),
      unknown_term("N_vr", "of |v| w", 0.015),
      unknown_term("N_d", "of u^2 sin delta", 0.015),
      unknown_term("N_nd", "of p^2 sin delta", 0.0006),
      unknown_term("N_vn", "of v p", 0.0015),
      unknown_term("N_rn", "of w p", 0.0015),
      unknown_term("N_bb", "of b |b|", 6e-05),
      unknown_term("N_ub", "of |u| b", 0.0009),
  }};

  std::array<T, parameters.size()> c;
  double L, d, rho, wave_speed;  ///< wave_speed: sqrt(g L) [m/s]

  Unknown(const std::array<T, parameters.size()>& value, const Ship& ship)
      : c(value),
        L(ship.particulars.L_pp),
        d(ship.particulars.d),
        rho(ship.particulars.rho),
        wave_speed(std::sqrt(kGravity_mps2 * ship.particulars.L_pp)) {}

  Vec3<T> force(const Situation<T>& at) const {
    using std::abs, std::sqrt;
    const T &u = at.nu_water(0), &v = at.nu_water(1);
    const T w = at.nu_water(2) * L;
    T p(0.0), b(0.0), s(0.0);
    if (at.actuators) {
      const Actuators<T>& a = *at.actuators;
      using std::sin;
      p = a[Channel::n_p] * d;
      b = a[Channel::n_bt] * d;
      s = sin(a[Channel::delta]) + 0.5 * (sin(a[Channel::delta_p]) + sin(a[Channel::delta_s]));
    }
    // The root's slope is without bound at rest: straight below a hundredth of the wave speed.
    const double least = 0.01 * wave_speed;
    const T size = abs(u), root = size > T(least) ? T(sqrt(size)) : T(size / std::sqrt(least));
    const T sign = u < T(0.0) ? T(-1.0) : T(1.0);
    const std::array<T, 12> even{u * wave_speed, sign * root * std::pow(wave_speed, 1.5),
                                 u * abs(u),     v * v,
                                 w * w,          v * w,
                                 u * p,          p * abs(p),
                                 u * u * s * s,  p * p * s * s,
                                 b * b,          u * abs(b)};
    const std::array<T, 13> odd{v * wave_speed, w * wave_speed, u * v, u * w, v * abs(v), w * abs(w), abs(v) * w,
                                u * u * s,      p * p * s,      v * p, w * p, b * abs(b), abs(u) * b};
    Vec3<T> sum = Vec3<T>::Zero();
    for (std::size_t i = 0; i < even.size(); ++i) sum(0) += c[i] * even[i];
    for (std::size_t i = 0; i < odd.size(); ++i) {
      sum(1) += c[even.size() + i] * odd[i];
      sum(2) += c[even.size() + odd.size() + i] * odd[i];
    }
    const double scale = 0.5 * rho * L * d;
    return {scale * sum(0), scale * sum(1), scale * L * sum(2)};
  }
};

}  // namespace leeway
