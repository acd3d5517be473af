#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct CenterOfGravity {
  static constexpr EffectInfo info{
      .name = "center-of-gravity",
      .number = "E16",
      .sentence = "The ship's center of gravity lies further ahead or astern than the model assumes.",
      .phrase = "a center of gravity {x_g_change_m!} further {x_g_change_m?ahead|astern}",
      .formula = "x_G + x_g_change; I_zG and the trim stay",
      .source = "the equations of motion (MMG standard method)",
      .look_alikes = "trim in turns, a wrong point of reference",
      .looks_like = {"trim"},
      .separating_maneuver = "turns that accelerate, zigzags at a high yaw rate",
      .formula_sd = 0.0,
      .needs_turns = true,
      .to_record = "the loading",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"x_g_change_m", "shift ahead", 0.0, kNone, -kUnbounded, kUnbounded, normal(0.0, 0.03, -0.3, 0.3),
       normal(0.0, 1.5, -15.0, 15.0)},
  }};

  T change_m;

  CenterOfGravity(const std::array<T, 1>& value, const Ship&) : change_m(value[0]) {}

  void change(ModelParts<T>& parts) const { parts.inertia.x_G += change_m; }
};

}  // namespace leeway
