#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct ThrusterSpeedLoss {
  static constexpr EffectInfo info{
      .name = "thruster-speed-loss",
      .number = "E30",
      .sentence = "The side thrusters lose effect when the ship moves ahead or astern, more than the model says.",
      .phrase = "side thrusters that lose 63 % of their thrust at {u_c_mps}",
      .formula = "thrust exp(-(u/u_c)^2), besides the loss that the thruster module has itself",
      .source =
          "form of the tool; size: the turning moment falls to about a half at 4 kn on a 60,000 t ship (KaMeWa and "
          "HyA, 1967)",
      .look_alikes = "thruster-gain",
      .looks_like = {"thruster-gain"},
      .separating_maneuver = "thruster pulses at rest and at two or three speeds",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"u_c_mps", "speed at which exp(-1) of the thrust is left; null: no further loss", kNone, kNone, 1e-3, kUnbounded,
       log_normal(0.35, 0.5, 0.05, 5.0), log_normal(2.5, 0.5, 0.35, 35.0)},
  }};

  T u_c;

  ThrusterSpeedLoss(const std::array<T, 1>& value, const Ship& ship) : u_c(value[0]) {
    if (!ship.modules->has([]<typename M>() { return HasSpeedLoss<M>; }))
      throw EffectNotApplicable("the ship has no side thruster");
  }

  void change(ModelParts<T>& parts) const {
    parts.modules.for_each([&]<typename M>(M& module) {
      if constexpr (HasSpeedLoss<M>) module.inverse_u_c = 1.0 / u_c;
    });
  }
};

}  // namespace leeway
