#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct RudderEffectiveness {
  static constexpr EffectInfo info{
      .name = "rudder-effectiveness",
      .number = "E26",
      .sentence = "A rudder gives another force than the model says: fouled, damaged, or one of two lost.",
      .phrase =
          "{k_R%} {k_R?more|less} rudder force; {k_P%} {k_P?more|less} force of the port rudder; {k_S%} "
          "{k_S?more|less} force of the starboard rudder",
      .cause_of_less = "a damaged or fouled rudder",
      .or_coefficient =
          "a wrong coefficient of the normal force; recordings with the rudder known to be sound would tell",
      .multiplies = MultipliedForce::rudder,
      .coefficients = {"rudder.gain", "rudder.gain_port", "rudder.gain_starboard"},
      .formula = "F_N k_R; of two rudders F_N,P k_R k_P and F_N,S k_R k_S",
      .source = "factor on the rudder's normal force",
      .look_alikes = "shallow-water, wake",
      .looks_like = {"shallow-water", "wake"},
      .separating_maneuver = "zigzags at several speeds; a difference between the sides names one rudder",
      .needs_turns = true,
  };
  static constexpr std::array<EffectParameter, 3> parameters{{
      {"k_R", "factor on every rudder's normal force", 1.0, 1.0, 0.0, kUnbounded, log_normal(0.9, 0.2, 0.2, 1.2),
       log_normal(0.9, 0.2, 0.2, 1.2)},
      {"k_P", "factor on the port rudder's", 1.0, 1.0, 0.0, kUnbounded, log_normal(0.9, 0.2, 0.2, 1.2),
       log_normal(0.9, 0.2, 0.2, 1.2)},
      {"k_S", "factor on the starboard rudder's", 1.0, 1.0, 0.0, kUnbounded, log_normal(0.9, 0.2, 0.2, 1.2),
       log_normal(0.9, 0.2, 0.2, 1.2)},
  }};

  T k_port, k_starboard;

  RudderEffectiveness(const std::array<T, 3>& value, const Ship& ship)
      : k_port(value[0] * value[1]), k_starboard(value[0] * value[2]) {
    if (!ship.modules->has([]<typename M>() { return HasNormalForce<M>; }))
      throw EffectNotApplicable("the ship has no rudder");
    if (!ship.has_twin_rudders() && (value[1] != T(1.0) || value[2] != T(1.0)))
      throw EffectNotApplicable("k_P and k_S belong to two rudders, and the ship has one: use k_R");
  }

  void change(ModelParts<T>& parts) const {
    parts.modules.for_each([&]<typename M>(M& module) {
      if constexpr (HasNormalForce<M>) module.scale_normal_force(k_port, k_starboard);
    });
  }
};

}  // namespace leeway
