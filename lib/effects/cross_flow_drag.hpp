#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct CrossFlowDrag {
  static constexpr EffectInfo info{
      .name = "cross-flow-drag",
      .number = "E18",
      .sentence = "The hull resists sideways flow more or less than the model says; seen at large drift and low speed.",
      .formula = "C_D C_D_gain in Y = -(rho/2) d C_D Int |v + C_rY r x| (v + C_rY r x) dx, and in N",
      .source = "Yoshimura, Nakao & Ishibashi (2009), MARSIM",
      .look_alikes = "trim, center-of-gravity, shallow-water in turns",
      .separating_maneuver = "crabbing, and turning on the spot",
  };
  static constexpr std::array<EffectParameter, 1> parameters{{
      {"C_D_gain", "factor on C_D", 1.0, kNone, 0.0, kUnbounded, log_normal(1.0, 0.2, 0.0, 3.0),
       log_normal(1.0, 0.2, 0.0, 3.0)},
  }};

  T gain;

  CrossFlowDrag(const std::array<T, 1>& value, const Ship& ship) : gain(value[0]) {
    if (!std::visit(
            [](const auto& c) {
              return requires { c.C_D; };
            },
            ship.hull))
      throw EffectNotApplicable("the ship's hull model has no cross-flow drag");
  }

  void change(ModelParts<T>& parts) const {
    std::visit(
        [&](auto& hull) {
          if constexpr (requires { hull.c.C_D; }) hull.c.C_D *= gain;
        },
        parts.modules.hull);
  }
};

}  // namespace leeway
