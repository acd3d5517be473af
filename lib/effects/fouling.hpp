#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct Fouling {
  static constexpr EffectInfo info{
      .name = "fouling",
      .number = "E14",
      .sentence =
          "The hull resists more or less than the model says, ahead and astern, with a slightly different wake: rough "
          "or overgrown, or cleaner than thought.",
      .phrase = "{resistance_increase%} {resistance_increase?more|less} resistance",
      .cause_of_more = "fouling",
      .or_coefficient = "a wrong coefficient of the resistance; recordings of the clean hull would tell",
      .multiplies = MultipliedForce::resistance,
      .coefficients = {"hull.resistance"},
      .formula = "X_0 (1 + resistance_increase); w_P + 0.03 resistance_increase",
      .source = "size: Townsin and ITTC roughness allowance, Schultz (2007): up to 86 % more power when heavily fouled",
      .look_alikes = "thrust-loss, shallow-water, head wind",
      .looks_like = {"thrust-loss", "shallow-water"},
      .separating_maneuver =
          "coast-down with n = 0 (fouling stays, thrust loss vanishes) and acceleration from rest (the reverse)",
      .to_record = "how fouled the hull is",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"resistance_increase", "added share of the resistance: 0.2 is 20 %", 0.0, kNone, -1.0, kUnbounded,
       log_normal(0.15, 0.7, 0.0, 0.8), log_normal(0.15, 0.7, 0.0, 0.8)},
  }};

  T f;

  Fouling(const std::array<T, 1>& value, const Ship&) : f(value[0]) {}

  void change(ModelParts<T>& parts) const {
    parts.modules.for_each([&]<typename M>(M& module) {
      if constexpr (HasResistance<M>) module.scale_resistance(1.0 + f);
      if constexpr (HasWake<M>) module.increase_wake(0.03 * f);
    });
  }
};

}  // namespace leeway
