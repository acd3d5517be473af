#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct RudderLatency {
  static constexpr EffectInfo info{
      .name = "rudder-latency",
      .number = "E39",
      .sentence = "The recorded rudder angles are late: the rudders have acted before.",
      .phrase = "rudder angles that are recorded {rudder_latency_s} late",
      .formula = "delta(t + latency), each rudder, linear between recorded angles; behind the end the last angle holds",
      .source = "a shift in time of the recorded angle: rudders and motion recorded by two clocks, or a slow indicator",
      .look_alikes = "sensors of motion that are early, actuator-delay (the other way), tug",
      .looks_like = {"added-mass", "tug"},
      .separating_maneuver = "rudder steps and ramps of two sizes",
      .formula_sd = 0.0,
      .needs_turns = true,
      .to_record = "rudder angles and motion by one clock",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"rudder_latency_s", "time by which the recorded angles are late", 0.0, kNone, 0.0, 1e4, uniform(0.0, 3.0),
       uniform(0.0, 10.0), ParameterRole::response_time},
  }};

  T latency;

  RudderLatency(const std::array<T, 1>& value, const Ship& ship) : latency(value[0]) {
    if (!ship.modules->has([]<typename M>() { return HasNormalForce<M>; }))
      throw EffectNotApplicable("the ship has no rudder");
  }

  void slow(RudderResponse& response) const requires std::same_as<T, double> { response.delay_s -= latency; }
};

}  // namespace leeway
