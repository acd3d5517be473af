#pragma once

#include "core/units.hpp"
#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct RudderOffset {
  static constexpr EffectInfo info{
      .name = "rudder-offset",
      .number = "E25",
      .sentence = "The rudder stands at another angle than its indicator says, by a constant.",
      .phrase = "a rudder {rudder_offset_deg!} further to {rudder_offset_deg?starboard|port} than recorded",
      .formula = "delta + rudder_offset, each rudder; positive turns the bow to starboard",
      .source = "a shift of the recorded angle",
      .look_alikes = "body-force, propeller-walk",
      .looks_like = {"body-force", "propeller-walk"},
      .separating_maneuver = "other revolutions at rudder amidships, coasting; wide movements of the rudders",
      .formula_sd = 0.0,
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"rudder_offset_deg", "added to each rudder angle", 0.0, kNone, -180.0, 180.0, normal(0.0, 1.0, -6.0, 6.0),
       normal(0.0, 1.0, -6.0, 6.0)},
  }};

  T offset;  ///< [rad]

  RudderOffset(const std::array<T, 1>& value, const Ship& ship) : offset(value[0] * kDegree) {
    if (!ship.modules->has([]<typename M>() { return HasNormalForce<M>; }))
      throw EffectNotApplicable("the ship has no rudder");
  }

  void act(Actuators<T>& actuators) const {
    for (const Channel rudder : {Channel::delta, Channel::delta_p, Channel::delta_s}) actuators[rudder] += offset;
  }
};

}  // namespace leeway
