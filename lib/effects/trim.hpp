#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct Trim {
  static constexpr EffectInfo info{
      .name = "trim",
      .number = "E17",
      .sentence = "The ship is trimmed: by the stern it keeps its course better, by the bow worse.",
      .phrase = "a trim by the {trim_over_draft?stern|bow} of {trim_over_draft%} of the draft",
      .formula =
          "tau = trim_over_draft: Y_v (1 + 2/3 tau), Y_r (1 + 0.80 tau), N_v (1 - 0.27 tau/l) with l = N_v/Y_v, that "
          "is N_v - 0.27 tau Y_v, N_r (1 + 0.30 tau); the other derivatives, mass and windage stay",
      .source =
          "Inoue, Hirano & Kijima (1981), Int. Shipbuilding Progress 28 (321); the four constants as cited "
          "elsewhere, not compared with the paper",
      .look_alikes = "center-of-gravity in turns, cross-flow-drag",
      .looks_like = {"center-of-gravity", "cross-flow-drag"},
      .separating_maneuver = "a spiral, or pull-outs to both sides",
      .needs_turns = true,
      .to_record = "the drafts fore and aft",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"trim_over_draft", "draft aft less draft forward, by the mean draft: + by the stern", 0.0, kNone, -1.0, 1.0,
       normal(0.0, 0.1, -0.5, 0.5), normal(0.0, 0.1, -0.5, 0.5)},
  }};

  T tau;

  Trim(const std::array<T, 1>& value, const Ship& ship) : tau(value[0]) {
    if (!ship.modules->has([]<typename M>() { return HasLinearDerivatives<M>; }))
      throw EffectNotApplicable("the ship's hull model has no linear derivatives");
  }

  void change(ModelParts<T>& parts) const {
    parts.modules.for_each([&]<typename M>(M& hull) {
      if constexpr (HasLinearDerivatives<M>) {
        hull.c.N_v -= 0.27 * tau * hull.c.Y_v;
        hull.c.Y_v *= 1.0 + 2.0 / 3.0 * tau;
        hull.c.Y_r *= 1.0 + 0.80 * tau;
        hull.c.N_r *= 1.0 + 0.30 * tau;
      }
    });
  }
};

}  // namespace leeway
