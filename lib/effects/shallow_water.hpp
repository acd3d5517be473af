#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct ShallowWater {
  static constexpr EffectInfo info{
      .name = "shallow-water",
      .number = "E4",
      .sentence = "Little water under the keel: a heavier ship that turns wider, drifts less and loses less speed.",
      .phrase = "shallow water: {h_over_T} times the draft",
      .formula =
          "y = h/T - 1, F = T/h, b = C_b B (1 + B/L)^2/T, K0 = 1 + 0.0775/y^2 - 0.011/y^3 + 0.000068/y^5, K1 = "
          "-0.0643/y + 0.0724/y^2 - "
          "0.0113/y^3 + 0.0000767/y^5, K2 = 0.0342/y (B/T <= 4) or 0.137 (T/B)/y; factors: m_y K0 + 2/3 K1 b + 8/15 K2 "
          "b^2; J_z K0 + "
          "8/15 K1 b + 40/105 K2 b^2; N_v K0 + K1 b + K2 b^2; Y_v -F + (1-F)^(-0.4 C_b B/T); N_r -F + (1-F)^(14.28 T/L "
          "- 1.5); "
          "resistance 1 + 0.388 F^2; w_P0 1 + (-4.932 + 0.6425 s - 0.0165 s^2) F^1.655 with s = C_b L/T; gamma_R by "
          "its two fits in F",
      .source =
          "Clarke (1997), Kijima et al. (1990), Taimuri et al. (2020), doi:10.1016/j.oceaneng.2020.108103; resistance: "
          "Furukawa et al. (2016); "
          "as coded in nikpau/mmgdynamics, with 0.137 T/B for its 0.137 B/T. Left out: the correction of t_P, which "
          "does not vanish in deep water, "
          "and squat. C_b follows from the mass",
      .look_alikes = "rudder-effectiveness, wake, draft, windage",
      .looks_like = {"rudder-effectiveness", "wake", "draft", "windage"},
      .separating_maneuver = "a 35 deg turn with a zigzag and a stop; or two known depths",
      .needs_turns = true,
      .changes_depth = true,
      .is_of_surroundings = true,
      .to_record = "the water depth",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"h_over_T", "water depth by draft; null: deep", kNone, kNone, 1.2, kUnbounded, log_normal(1.6, 0.4, 1.2, 20.0),
       log_normal(1.6, 0.4, 1.2, 20.0)},
  }};

  T h_over_T;

  ShallowWater(const std::array<T, 1>& value, const Ship&) : h_over_T(value[0]) {}

  struct Factors {
    T m_y, J_z, Y_v, N_v, N_r, resistance, w_P0, gamma_R;
  };

  Factors factors(const Ship& ship) const {
    using std::pow;
    const Particulars& p = ship.particulars;
    const double L = p.L_pp, B = p.B, d = p.d, C_b = ship.block_coefficient();
    const T y = h_over_T - 1.0, F = 1.0 / h_over_T, y2 = y * y, y3 = y2 * y, y5 = y3 * y2;
    const T K0 = 1.0 + 0.0775 / y2 - 0.011 / y3 + 0.000068 / y5;
    const T K1 = -0.0643 / y + 0.0724 / y2 - 0.0113 / y3 + 0.0000767 / y5;
    const T K2 = (B / d <= 4.0 ? 0.0342 : 0.137 * d / B) / y;
    const double b = C_b * B * (1.0 + B / L) * (1.0 + B / L) / d;

    const double s = C_b * L / d, q = C_b * B / L;
    const T gamma_R = F <= T(-0.332 * d / B + 0.581)
                          ? T(1.0 + (-135.25 + 2432.95 * q - 10137.7 * q * q) * pow(F, 4.81))
                          : T(1.0 + (-10.258 + 178.207 * q - 686.25 * q * q) * (-3.854 + 13.665 * F - 10.468 * F * F));
    return {K0 + 2.0 / 3.0 * K1 * b + 8.0 / 15.0 * K2 * b * b,
            K0 + 8.0 / 15.0 * K1 * b + 40.0 / 105.0 * K2 * b * b,
            -F + pow(1.0 - F, -0.4 * C_b * B / d),
            K0 + K1 * b + K2 * b * b,
            -F + pow(1.0 - F, 14.28 * d / L - 1.5),
            1.0 + 0.388 * F * F,
            1.0 + (-4.932 + 0.6425 * s - 0.0165 * s * s) * pow(F, 1.655),
            gamma_R};
  }

  void change(ModelParts<T>& parts) const {
    const Factors k = factors(parts.ship);
    Inertia<T>& inertia = parts.inertia;
    inertia.m_y *= k.m_y;
    inertia.I_z += (k.J_z - 1.0) * inertia.added_moment(parts.ship.particulars.L_pp);
    parts.modules.for_each([&]<typename M>(M& module) {
      if constexpr (HasLinearDerivatives<M>) {
        module.c.Y_v *= k.Y_v;
        module.c.N_v *= k.N_v;
        module.c.N_r *= k.N_r;
      }
      if constexpr (HasResistance<M>) module.scale_resistance(k.resistance);
      if constexpr (HasWake<M>) module.scale_wake(k.w_P0);
      if constexpr (HasFlowStraightening<M>) module.scale_flow_straightening(k.gamma_R);
    });
  }
};

}  // namespace leeway
