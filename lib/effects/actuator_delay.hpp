#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct ActuatorDelay {
  static constexpr EffectInfo info{
      .name = "actuator-delay",
      .number = "E31",
      .sentence = "The rudders act later than their recorded angles say.",
      .phrase = "rudders that act {delay_s} later than recorded",
      .formula = "delta(t - delay), each rudder, linear between known angles; before the start the first angle holds",
      .source =
          "a shift in time of the recorded angle; nothing where the angles are measured at the stock without delay",
      .look_alikes = "actuator-rate, actuator-lag, added-mass (J_z)",
      .looks_like = {"actuator-rate", "actuator-lag", "added-mass"},
      .separating_maneuver = "rudder steps and ramps of two sizes",
      .formula_sd = 0.0,
      .needs_turns = true,
      .to_record = "the angles and revolutions that are reached, beside those ordered",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"delay_s", "time by which the rudders act later", 0.0, kNone, 0.0, 1e4, uniform(0.0, 3.0), uniform(0.0, 10.0),
       ParameterRole::response_time},
  }};

  T delay;

  ActuatorDelay(const std::array<T, 1>& value, const Ship& ship) : delay(value[0]) {
    if (!ship.modules->has([]<typename M>() { return HasNormalForce<M>; }))
      throw EffectNotApplicable("the ship has no rudder");
  }

  void slow(RudderResponse& response) const requires std::same_as<T, double> { response.delay_s += delay; }
};

}  // namespace leeway
