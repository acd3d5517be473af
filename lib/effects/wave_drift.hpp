#pragma once

#include "core/units.hpp"
#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct WaveDrift {
  static constexpr EffectInfo info{
      .name = "wave-drift",
      .number = "E12",
      .sentence = "Waves push the ship slowly to leeward: the mean second-order force of an irregular sea.",
      .phrase = "waves of {hs_m} significant height from {wave_from_deg}",
      .formula =
          "mu = wave_from - psi; X = -rho g (B^2/L)(hs^2/8) C_X cos mu; Y = -rho g L (hs^2/16) C_Y sin mu |sin mu|; "
          "N = -rho g L^2 (hs^2/16) C_N sin 2 mu",
      .source =
          "form of the mean force in regular waves with m_0 = hs^2/16 (Faltinsen 1990, Sea Loads; full reflection is "
          "C_Y = 1); "
          "the default coefficients are mid-range values, ours",
      .look_alikes = "unmeasured-wind, earth-force",
      .looks_like = {"unmeasured-wind", "earth-force"},
      .separating_maneuver = "a change of speed; runs in calm wind with swell; no correlation with gusts",
      .is_of_surroundings = true,
      .to_record = "the waves",
  };
  static constexpr std::array<EffectParameter, 5> parameters{{
      {"hs_m", "significant wave height", 0.0, kNone, 0.0, kUnbounded, log_normal(0.01, 0.8, 0.0, 0.1),
       log_normal(0.5, 0.8, 0.0, 6.0)},
      {"wave_from_deg", "direction that the waves come from", kNone, kNone, -360.0, 360.0, kAnyDirection,
       kAnyDirection},
      {"C_X", "coefficient of the added resistance", kNone, 1.0, 0.0, kUnbounded, log_normal(1.0, 0.6, 0.1, 5.0),
       log_normal(1.0, 0.6, 0.1, 5.0)},
      {"C_Y", "coefficient of the lateral drift force", kNone, 0.6, 0.0, kUnbounded, uniform(0.2, 1.0),
       uniform(0.2, 1.0)},
      {"C_N", "coefficient of the yaw moment", kNone, 0.025, -kUnbounded, kUnbounded, uniform(0.0, 0.05),
       uniform(0.0, 0.05)},
  }};

  T X0, Y0, N0;  ///< at mu = 0, 90 and 45 deg [N, N, N m]
  Vec2<T> from;  ///< unit vector in earth axes

  WaveDrift(const std::array<T, 5>& value, const Ship& ship) {
    using std::cos, std::sin;
    const Particulars& p = ship.particulars;
    const T q = p.rho * kGravity_mps2 * value[0] * value[0];  // [N/m]
    X0 = q * (p.B * p.B / p.L_pp / 8.0) * value[2];
    Y0 = q * (p.L_pp / 16.0) * value[3];
    N0 = q * (p.L_pp * p.L_pp / 16.0) * value[4];
    from = {cos(value[1] * kDegree), sin(value[1] * kDegree)};
  }

  Vec3<T> force(const Situation<T>& at) const {
    using std::abs;
    const Vec2<T> mu = at.to_ship(from);  // (cos mu, sin mu)
    return {-X0 * mu(0), -Y0 * mu(1) * abs(mu(1)), -N0 * 2.0 * mu(1) * mu(0)};
  }
};

}  // namespace leeway
