#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct Windage {
  static constexpr EffectInfo info{
      .name = "windage",
      .number = "E8",
      .sentence = "The wind force differs from what the model says: deck cargo, other areas, other coefficients.",
      .phrase =
          "another wind force: {kX%} {kX?more|less} ahead; {kY%} {kY?more|less} sideways; {kN%} {kN?more|less} in yaw",
      .cause_of_less = "other areas above the water",
      .cause_of_more = "deck load or other areas above the water",
      .or_coefficient = "a wrong wind coefficient; recordings with another deck load would tell",
      .coefficients = {"wind.k_X", "wind.k_Y", "wind.k_N"},
      .formula = "X_A kX, Y_A kY, N_A kN",
      .source = "gains on the ship's wind module (Fujiwara, Ueno & Nimura 1998)",
      .look_alikes = "anemometer (force goes with its square), draft, unmeasured-wind",
      .looks_like = {"anemometer", "draft", "unmeasured-wind"},
      .separating_maneuver = "different wind speeds and relative wind directions; gusts",
  };
  static constexpr std::array<EffectParameter, 3> parameters{{
      {"kX", "gain of the longitudinal wind force", 1.0, 1.0, 0.0, kUnbounded, log_normal(1.0, 0.2, 0.0, 3.0),
       log_normal(1.0, 0.2, 0.0, 3.0)},
      {"kY", "gain of the lateral wind force", 1.0, 1.0, 0.0, kUnbounded, log_normal(1.0, 0.15, 0.0, 3.0),
       log_normal(1.0, 0.15, 0.0, 3.0)},
      {"kN", "gain of the wind's yaw moment", 1.0, 1.0, 0.0, kUnbounded, log_normal(1.0, 0.3, 0.0, 3.0),
       log_normal(1.0, 0.3, 0.0, 3.0)},
  }};

  T kX, kY, kN;

  Windage(const std::array<T, 3>& value, const Ship& ship) : kX(value[0]), kY(value[1]), kN(value[2]) {
    if (!ship.modules->wind) throw EffectNotApplicable("the ship has no wind module");
  }

  void change(ModelParts<T>& parts) const {
    parts.modules.for_each([&]<typename M>(M& module) {
      if constexpr (HasWindForce<M>) module.scale(kX, kY, kN);
    });
  }
};

}  // namespace leeway
