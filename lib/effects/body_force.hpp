#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct BodyForce {
  static constexpr EffectInfo info{
      .name = "body-force",
      .number = "E46",
      .sentence = "An unexplained constant force that turns with the ship.",
      .phrase = "a constant force on the ship: {X_N} ahead; {Y_N} to starboard; a moment of {N_Nm} to starboard",
      .formula = "(X, Y, N) constant in ship axes at midship",
      .source = "generic: a competitor that a specific name has to beat",
      .look_alikes = "rudder-offset, propeller-walk, bank",
      .looks_like = {"rudder-offset", "propeller-walk", "bank"},
      .separating_maneuver = "other revolutions and speeds",
      .formula_sd = 0.0,
      .to_ensemble = EnsembleForm::body_acceleration,
  };
  static constexpr std::array<EffectParameter, 3> parameters{{
      {"X_N", "force ahead", 0.0, 0.0, -kUnbounded, kUnbounded, normal(0.0, 0.25, -10.0, 10.0),
       normal(0.0, 3.2e4, -2e6, 2e6)},
      {"Y_N", "force to starboard", 0.0, 0.0, -kUnbounded, kUnbounded, normal(0.0, 0.25, -10.0, 10.0),
       normal(0.0, 3.2e4, -2e6, 2e6)},
      {"N_Nm", "moment to starboard", 0.0, 0.0, -kUnbounded, kUnbounded, normal(0.0, 0.12, -10.0, 10.0),
       normal(0.0, 7.7e5, -1e8, 1e8)},
  }};

  Vec3<T> F;

  BodyForce(const std::array<T, 3>& value, const Ship&) : F(value[0], value[1], value[2]) {}

  Vec3<T> force(const Situation<T>&) const { return F; }
};

}  // namespace leeway
