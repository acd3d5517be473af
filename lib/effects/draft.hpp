#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct Draft {
  static constexpr EffectInfo info{
      .name = "draft",
      .number = "E15",
      .sentence = "The ship floats deeper or higher than the model assumes: another mass, hull force and windage.",
      .phrase = "a draft {draft_change%} {draft_change?larger|smaller}",
      .formula =
          "d (1 + e): masses, inertia and hull forces by (1 + e); Y_v, N_v, N_r besides by the ratio of -(pi k/2 + 1.4 "
          "C_b B/L), -k, "
          "-0.54 k + k^2 with k = 2d/L; A_L - L d e, A_T - B d e; C_b from the mass; propeller and rudder immersion "
          "are left out",
      .source = "Kijima et al. (1990) for the derivatives; the rest is geometry",
      .look_alikes = "added-mass, a common factor on all forces, windage",
      .looks_like = {"added-mass", "windage"},
      .separating_maneuver = "a thruster or propeller step from rest: a known force shows the mass",
      .needs_turns = true,
      .to_record = "the drafts fore and aft",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"draft_change", "e, added share of the draft: 0.1 is 10 %", 0.0, kNone, -0.9, 10.0, normal(0.0, 0.1, -0.5, 0.5),
       normal(0.0, 0.1, -0.5, 0.5)},
  }};

  T e;

  Draft(const std::array<T, 1>& value, const Ship&) : e(value[0]) {}

  void change(ModelParts<T>& parts) const {
    const Particulars& p = parts.ship.particulars;
    const T gain = 1.0 + e;
    Inertia<T>& inertia = parts.inertia;
    inertia.m *= gain;
    inertia.m_x *= gain;
    inertia.m_y *= gain;
    inertia.I_z *= gain;

    const double k0 = 2.0 * p.d / p.L_pp, C_b = parts.ship.block_coefficient();
    const T k = k0 * gain;
    const auto Y_v = [&](const auto& x) { return 0.5 * kPi * x + 1.4 * C_b * p.B / p.L_pp; };
    const auto N_r = [](const auto& x) { return -0.54 * x + x * x; };
    const T Y_v_ratio = Y_v(k) / Y_v(k0), N_v_ratio = k / k0, N_r_ratio = N_r(k) / N_r(k0);
    parts.modules.scale("hull", gain);
    parts.modules.for_each([&]<typename M>(M& module) {
      if constexpr (HasLinearDerivatives<M>) {
        module.c.Y_v *= Y_v_ratio;
        module.c.N_v *= N_v_ratio;
        module.c.N_r *= N_r_ratio;
      }
      if constexpr (HasWindForce<M>) module.add_areas(-p.B * p.d * e, -p.L_pp * p.d * e);
    });
  }
};

}  // namespace leeway
