#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct Wake {
  static constexpr EffectInfo info{
      .name = "wake",
      .number = "E23",
      .sentence =
          "The propeller works in a stronger or weaker wake than the model says; thrust and slipstream change "
          "together.",
      .phrase = "a wake fraction {wake_fraction_increase!} {wake_fraction_increase?larger|smaller}",
      .formula = "w_P + wake_fraction_increase, ahead",
      .source = "shift of the ship's wake fraction",
      .look_alikes = "rudder-effectiveness, shallow-water",
      .looks_like = {"rudder-effectiveness", "shallow-water"},
      .separating_maneuver = "the same rudder angle at several ratios n/u, n = 0 among them",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"wake_fraction_increase", "added to w_P", 0.0, kNone, -1.0, 1.0, normal(0.0, 0.05, -0.3, 0.3),
       normal(0.0, 0.05, -0.3, 0.3)},
  }};

  T increase;

  Wake(const std::array<T, 1>& value, const Ship& ship) : increase(value[0]) {
    if (!ship.modules->has([]<typename M>() { return HasWake<M>; }))
      throw EffectNotApplicable("the ship has no propeller in a wake");
  }

  void change(ModelParts<T>& parts) const {
    parts.modules.for_each([&]<typename M>(M& module) {
      if constexpr (HasWake<M>) module.increase_wake(increase);
    });
  }
};

}  // namespace leeway
