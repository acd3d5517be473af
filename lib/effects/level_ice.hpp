#pragma once

#include "core/units.hpp"
#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct LevelIce {
  static constexpr EffectInfo info{
      .name = "level-ice",
      .number = "E45",
      .sentence = "The ship breaks its way through level ice, which holds it back even at low speed.",
      .phrase = "level ice {ice_thickness_m} thick",
      .formula =
          "psi = atan(tan phi/sin alpha), phi stem angle, alpha entrance angle, mu friction, sigma flexural strength; "
          "R_c = sigma/2 h^2 (tan phi + mu cos phi/cos psi)/(1 - mu sin phi/cos psi); R_b = 27/64 sigma B h^1.5/sqrt(E/"
          "(12 (1 - 0.3^2) g rho)) (tan psi + mu cos phi/(sin alpha cos psi)) (1 + 1/cos psi); R_s = (rho - 900) g h B "
          "(d (B + d)/(B + 2 d) + mu (0.7 L - d/tan phi - B/(4 tan alpha) + d cos phi cos psi sqrt(1/sin^2 phi + "
          "1/tan^2 "
          "alpha))); R = (R_c + R_b) (1 + 1.4 |u|/sqrt(g h)) + R_s (1 + 9.4 |u|/sqrt(g L)); X = -R u/sqrt(u^2 + "
          "u_s^2), "
          "u over ground, u_s = 0.005 sqrt(g L)",
      .source =
          "Lindqvist (1989), A straightforward method for calculation of ice resistance of ships, POAC 89, for a ship "
          "that goes ahead in ice at rest; formula from citations, not compared with the paper. Ours: astern as ahead; "
          "u_s, so that the force fades at rest. Left out: what the ice does to sway and yaw, so that turning is too "
          "easy. Strength, modulus and friction are usual ones of sea ice, by scale at 3 m; no ship here states its "
          "bow's angles: the defaults, of an icebreaking bow, and all priors are estimated",
      .look_alikes = "fouling, thrust-loss",
      .looks_like = {"fouling", "thrust-loss"},
      .separating_maneuver = "coasting to rest: ice stops the ship at once where water lets it glide",
      .is_of_surroundings = true,
      .search = SearchStart::none,
  };
  static constexpr std::array<EffectParameter, 6> parameters{{
      {"ice_thickness_m", "thickness of the ice", 0.0, kNone, 0.0, kUnbounded, log_normal(0.006, 0.7, 0.0, 0.06),
       log_normal(0.3, 0.7, 0.0, 3.0)},
      {"flexural_strength_pa", "stress at which it breaks in bending", kNone, 5e5, 1.0, kUnbounded,
       log_normal(1e4, 0.3, 1e3, 1e5), log_normal(5e5, 0.3, 5e4, 5e6)},
      {"elastic_modulus_pa", "its modulus of elasticity", kNone, 2e9, 1.0, kUnbounded, log_normal(4e7, 0.5, 2e6, 4e8),
       log_normal(2e9, 0.5, 1e8, 2e10)},
      {"friction", "coefficient of friction between hull and ice", kNone, 0.1, 0.0, 1.0, uniform(0.05, 0.2),
       uniform(0.05, 0.2)},
      {"stem_angle_deg", "of the stem with the waterline", kNone, 30.0, 5.0, 85.0, uniform(15.0, 45.0),
       uniform(15.0, 45.0)},
      {"entrance_angle_deg", "of the waterline at the bow with the center plane", kNone, 30.0, 5.0, 85.0,
       uniform(15.0, 45.0), uniform(15.0, 45.0)},
  }};
  static constexpr double kIceDensity_kgpm3 = 900.0, kPoisson = 0.3;

  T R_0 = T(0.0), slope = T(0.0);  ///< resistance towards rest [N], and its increase with speed [N s/m]
  double fading_mps;               ///< u_s

  LevelIce(const std::array<T, 6>& value, const Ship& ship) {
    using std::cos, std::sin, std::sqrt, std::tan;
    const Particulars& p = ship.particulars;
    const double g = kGravity_mps2, L = p.L_pp, B = p.B, d = p.d;
    fading_mps = 0.005 * std::sqrt(g * L);
    const T &h = value[0], &sigma = value[1], &E = value[2], &mu = value[3];
    const T phi = value[4] * kDegree, alpha = value[5] * kDegree;
    const T tan_psi = tan(phi) / sin(alpha), per_cos_psi = sqrt(1.0 + tan_psi * tan_psi);
    const T down = 1.0 - mu * sin(phi) * per_cos_psi;
    if (!(down > T(0.0))) throw EffectNotApplicable("the stem is too steep for this friction to bend the ice down");
    if (!(h > T(0.0))) return;

    const T R_c = 0.5 * sigma * h * h * (tan(phi) + mu * cos(phi) * per_cos_psi) / down;
    const T R_b = 27.0 / 64.0 * sigma * B * h * sqrt(h) / sqrt(E / (12.0 * (1.0 - kPoisson * kPoisson) * g * p.rho)) *
                  (tan_psi + mu * cos(phi) * per_cos_psi / sin(alpha)) * (1.0 + per_cos_psi);
    const T bow = sqrt(1.0 / (sin(phi) * sin(phi)) + 1.0 / (tan(alpha) * tan(alpha)));
    const T covered = 0.7 * L - d / tan(phi) - B / (4.0 * tan(alpha)) + d * cos(phi) / per_cos_psi * bow;
    const T R_s = (p.rho - kIceDensity_kgpm3) * g * h * B * (d * (B + d) / (B + 2.0 * d) + mu * covered);
    R_0 = R_c + R_b + R_s;
    slope = 1.4 * (R_c + R_b) / sqrt(g * h) + 9.4 * R_s / std::sqrt(g * L);
  }

  Vec3<T> force(const Situation<T>& at) const {
    using std::abs, std::sqrt;
    const T& u = at.nu_ground(0);
    return {-(R_0 + slope * abs(u)) * u / sqrt(u * u + fading_mps * fading_mps), T(0.0), T(0.0)};
  }
};

}  // namespace leeway
