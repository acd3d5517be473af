#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct VectwinInteraction {
  static constexpr EffectInfo info{
      .name = "vectwin-interaction",
      .number = "E28",
      .sentence = "Two rudders that stand at different angles disturb each other more than the model says.",
      .phrase = "rudders that lose {k_interaction%} {k_interaction?more|less} force to each other at a right angle",
      .formula =
          "g = |sin(delta_s - delta_p)|; F_N,P and F_N,S by (1 - k_interaction g); X - k_interaction g (rho/2) A_R "
          "(0.7 n P)^2 with the propeller's pitch P, 0 at n < 0",
      .source =
          "form of the tool (ours), on top of the interaction that the rudder module has (Kang, Nagarajan, Hasegawa & "
          "Sano 2008, JMST 13, 207-222)",
      .look_alikes = "rudder-effectiveness, thrust-loss at open rudders",
      .looks_like = {"rudder-effectiveness", "thrust-loss"},
      .separating_maneuver = "opening and closing both rudders (clamshell) at constant revolutions",
      .needs_turns = true,
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"k_interaction", "share that is lost at a right angle between the rudders", 0.0, kNone, -1.0, 1.0,
       normal(0.0, 0.1, -0.5, 0.5), normal(0.0, 0.1, -0.5, 0.5)},
  }};

  T k;

  VectwinInteraction(const std::array<T, 1>& value, const Ship& ship) : k(value[0]) {
    if (!ship.modules->rudder) throw EffectNotApplicable("the ship has no rudders");
    if (!ship.has_twin_rudders()) throw EffectNotApplicable("the ship has a single rudder");
  }

  void change(ModelParts<T>& parts) const {
    parts.modules.for_each([&]<typename M>(M& module) {
      if constexpr (HasTwinRudders<M>) module.k_interaction = module.k_interaction.value_or(T(0.0)) + k;
    });
  }
};

}  // namespace leeway
