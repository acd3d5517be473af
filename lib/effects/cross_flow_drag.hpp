#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct CrossFlowDrag {
  static constexpr EffectInfo info{
      .name = "cross-flow-drag",
      .number = "E18",
      .sentence = "The hull resists sideways flow more or less than the model says; seen at large drift and low speed.",
      .phrase = "{C_D_gain%} {C_D_gain?more|less} cross-flow drag",
      .cause_of_less = "another loading",
      .cause_of_more = "bilge keels or another loading",
      .or_coefficient =
          "a wrong coefficient of the cross-flow drag; recordings of a loading in which the hull was tested would tell",
      .coefficients = {"hull.C_D"},
      .formula = "C_D C_D_gain in Y = -(rho/2) d C_D Int |v + C_rY r x| (v + C_rY r x) dx, and in N",
      .source = "Yoshimura, Nakao & Ishibashi (2009), MARSIM",
      .look_alikes = "trim, center-of-gravity, shallow-water in turns",
      .looks_like = {"trim", "center-of-gravity", "shallow-water"},
      .separating_maneuver = "crabbing, and turning on the spot",
      .needs_turns = true,
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"C_D_gain", "factor on C_D", 1.0, kNone, 0.0, kUnbounded, log_normal(1.0, 0.2, 0.0, 3.0),
       log_normal(1.0, 0.2, 0.0, 3.0)},
  }};

  T gain;

  CrossFlowDrag(const std::array<T, 1>& value, const Ship& ship) : gain(value[0]) {
    if (!ship.modules->has([]<typename M>() { return HasCrossFlowDrag<M>; }))
      throw EffectNotApplicable("the ship's hull model has no cross-flow drag");
  }

  void change(ModelParts<T>& parts) const {
    parts.modules.for_each([&]<typename M>(M& module) {
      if constexpr (HasCrossFlowDrag<M>) module.c.C_D *= gain;
    });
  }
};

}  // namespace leeway
