#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct ThrustLoss {
  static constexpr EffectInfo info{
      .name = "thrust-loss",
      .number = "E22",
      .sentence =
          "The propeller gives another thrust at the same revolutions than the model says, and the rudder another "
          "slipstream.",
      .phrase = "{k_T%} {k_T?more|less} thrust",
      .cause_of_less = "a worn or fouled propeller",
      .or_coefficient = "a wrong K_T; a bollard pull, or recordings with a clean propeller would tell",
      .multiplies = MultipliedForce::thrust,
      .coefficients = {"propeller.K_T"},
      .formula = "K_T k_T, ahead and astern",
      .source = "factor on the ship's open-water curves",
      .look_alikes = "fouling, wake",
      .looks_like = {"fouling", "wake"},
      .separating_maneuver = "coast-down with n = 0, and the rudder's response at the same revolutions",
      .to_record = "the propeller's thrust",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"k_T", "factor on K_T", 1.0, kNone, 0.0, kUnbounded, log_normal(0.95, 0.1, 0.5, 1.1),
       log_normal(0.95, 0.1, 0.5, 1.1)},
  }};

  T k_T;

  ThrustLoss(const std::array<T, 1>& value, const Ship& ship) : k_T(value[0]) {
    if (!ship.modules->has([]<typename M>() { return HasThrust<M>; }))
      throw EffectNotApplicable("the ship has no propeller");
  }

  void change(ModelParts<T>& parts) const {
    parts.modules.for_each([&]<typename M>(M& module) {
      if constexpr (HasThrust<M>) module.scale_thrust(k_T);
    });
  }
};

}  // namespace leeway
