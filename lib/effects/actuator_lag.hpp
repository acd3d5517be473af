#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct ActuatorLag {
  static constexpr EffectInfo info{
      .name = "actuator-lag",
      .number = "E33",
      .sentence = "The rudders approach their recorded angles only gradually.",
      .phrase = "rudders that approach their recorded angles with a time constant of {lag_s}",
      .formula = "d(delta_acting)/dt = (delta - delta_acting)/lag; delta_acting = delta at the start",
      .source =
          "first-order lag behind the recorded angle; nothing where the angles are measured at the stock. The prior is "
          "ours",
      .look_alikes = "actuator-delay, actuator-rate, added-mass (J_z)",
      .looks_like = {"actuator-delay", "actuator-rate", "added-mass"},
      .separating_maneuver = "rudder steps, which a lag rounds and a delay only shifts, of two sizes",
      .formula_sd = 0.0,
      .needs_turns = true,
      .to_record = "the angles and revolutions that are reached, beside those ordered",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"lag_s", "time constant", 0.0, kNone, 0.0, 1e4, uniform(0.0, 3.0), uniform(0.0, 10.0),
       ParameterRole::response_time},
  }};

  T lag;

  ActuatorLag(const std::array<T, 1>& value, const Ship& ship) : lag(value[0]) {
    if (!ship.modules->has([]<typename M>() { return HasNormalForce<M>; }))
      throw EffectNotApplicable("the ship has no rudder");
  }

  void slow(RudderResponse& response) const requires std::same_as<T, double> { response.lag_s += lag; }
};

}  // namespace leeway
