#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct ThrusterGain {
  static constexpr EffectInfo info{
      .name = "thruster-gain",
      .number = "E29",
      .sentence = "The bow thruster gives less or more thrust than the model says.",
      .phrase = "{k_BT%} {k_BT?more|less} thrust of the bow thruster",
      .formula = "K_T,BT k_BT, to both sides",
      .source = "factor on the bow thruster's thrust",
      .look_alikes = "thruster-speed-loss",
      .looks_like = {"thruster-speed-loss"},
      .separating_maneuver = "thruster pulses at rest and at two or three speeds",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"k_BT", "factor on the bow thruster's thrust", 1.0, kNone, 0.0, kUnbounded, log_normal(0.9, 0.2, 0.0, 1.5),
       log_normal(0.9, 0.2, 0.0, 1.5)},
  }};

  T k_BT;

  ThrusterGain(const std::array<T, 1>& value, const Ship& ship) : k_BT(value[0]) {
    if (ship.find_actuator(Channel::n_bt) == nullptr) throw EffectNotApplicable("the ship has no bow thruster");
  }

  void change(ModelParts<T>& parts) const {
    parts.modules.for_each([&]<typename M>(M& thruster) {
      if constexpr (HasSideThrust<M>) {
        if (thruster.c.channel != Channel::n_bt) return;
        thruster.c.K_T_positive *= k_BT;
        thruster.c.K_T_negative *= k_BT;
      }
    });
  }
};

}  // namespace leeway
