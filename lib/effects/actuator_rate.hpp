#pragma once

#include "core/units.hpp"
#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct ActuatorRate {
  static constexpr EffectInfo info{
      .name = "actuator-rate",
      .number = "E32",
      .sentence = "The rudders turn more slowly than their recorded angles say: the steering gear has less speed.",
      .phrase = "rudders that turn no faster than {rate_degps}",
      .formula = "d(delta_acting)/dt = what brings it to delta, at most rate; delta_acting = delta at the start",
      .source =
          "limited rate behind the recorded angle; nothing where the angles are measured at the stock. The prior is "
          "ours, around the 2.3 deg/s that SOLAS II-1/29 asks for at full scale (35 deg to 30 deg on the other side in "
          "28 s), by the root of the length at 3 m",
      .look_alikes = "actuator-lag, actuator-delay",
      .looks_like = {"actuator-lag", "actuator-delay"},
      .separating_maneuver = "large rudder steps beside small ones: small steps are not slowed",
      .formula_sd = 0.0,
      .needs_turns = true,
      .to_record = "the angles and revolutions that are reached, beside those ordered",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"rate_degps", "fastest rate of the rudders; null: as recorded", kNone, kNone, 1e-3, kUnbounded,
       log_normal(10.0, 0.7, 0.5, 100.0), log_normal(2.3, 0.5, 0.3, 20.0)},
  }};

  T rate;  ///< [rad/s]

  ActuatorRate(const std::array<T, 1>& value, const Ship& ship) : rate(value[0] * kDegree) {
    if (!ship.modules->has([]<typename M>() { return HasNormalForce<M>; }))
      throw EffectNotApplicable("the ship has no rudder");
  }

  void slow(RudderResponse& response) const requires std::same_as<T, double> {
    response.rate_radps = std::min(response.rate_radps, rate);
  }
};

}  // namespace leeway
