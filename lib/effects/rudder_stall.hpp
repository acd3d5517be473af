#pragma once

#include "core/units.hpp"
#include "effects/effect.hpp"
#include "forces/normal_force_shape.hpp"

namespace leeway {

template <typename T>
struct RudderStall {
  static constexpr EffectInfo info{
      .name = "rudder-stall",
      .number = "E27",
      .sentence = "At large angles the flow leaves the rudder, which then gives less force than the model says.",
      .phrase = "a rudder that stalls beyond {stall_angle_deg}",
      .formula =
          "a: acute angle between inflow and rudder; F_N (1 - stall_depth (1 - exp(-(a - stall_angle)/stall_width))) "
          "where a > stall_angle",
      .source = "form of the tool (ours): continuous, without hysteresis; fishtail rudders stall later than others",
      .look_alikes = "rudder-effectiveness, shallow-water in hard turns",
      .looks_like = {"rudder-effectiveness", "shallow-water"},
      .separating_maneuver = "turns at 35 and at 15 deg; hovering with VecTwin rudders",
      .needs_turns = true,
  };
  static constexpr std::array<EffectParameter, 3> parameters{{
      {"stall_angle_deg", "angle of attack at which it begins; null: the rudder does not stall", kNone, kNone, 1.0,
       90.0, normal(30.0, 6.0, 10.0, 80.0), normal(30.0, 6.0, 10.0, 80.0)},
      {"stall_depth", "share of the force that is lost far beyond", kNone, 0.4, 0.0, 1.0, uniform(0.2, 0.6),
       uniform(0.2, 0.6)},
      {"stall_width_deg", "how far beyond 63 % of that are lost", kNone, 11.5, 0.1, 90.0,
       log_normal(11.5, 0.4, 2.0, 40.0), log_normal(11.5, 0.4, 2.0, 40.0)},
  }};

  StallLoss<T> loss;

  RudderStall(const std::array<T, 3>& value, const Ship& ship)
      : loss{value[0] * kDegree, value[1], value[2] * kDegree} {
    if (!ship.modules->has([]<typename M>() { return HasNormalForce<M>; }))
      throw EffectNotApplicable("the ship has no rudder");
  }

  void change(ModelParts<T>& parts) const {
    parts.modules.for_each([&]<typename M>(M& module) {
      if constexpr (HasNormalForce<M>) module.shape.stall = loss;
    });
  }
};

}  // namespace leeway
