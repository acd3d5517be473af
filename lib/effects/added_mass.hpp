#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct AddedMass {
  static constexpr EffectInfo info{
      .name = "added-mass",
      .number = "E19",
      .sentence = "The water that the ship has to accelerate with itself is more or less than the model says.",
      .phrase =
          "another added mass: {k_mx%} {k_mx?more|less} ahead; {k_my%} {k_my?more|less} sideways; {k_Jz%} "
          "{k_Jz?more|less} in yaw",
      .cause_of_less = "another loading",
      .cause_of_more = "shallow water or another loading",
      .or_coefficient = "a wrong added mass; captive tests would tell",
      .coefficients = {"inertia.m_x", "inertia.m_y", "inertia.I_z"},
      .formula =
          "m_x k_mx, m_y k_my, J_z k_Jz; where a ship gives only I_zG + J_z, J_z is what remains of it after I_zG = m "
          "(0.25 L)^2, not below 0",
      .source = "factors on the ship's added mass; 0.25 L: MMG standard method",
      .look_alikes = "draft, actuator-delay, errors of the coefficients: within 20 % it is hardly ever identifiable",
      .looks_like = {"draft", "actuator-delay"},
      .separating_maneuver = "thruster on and off in pulses, zigzag 10/10 at a high yaw rate",
      .needs_turns = true,
  };
  static constexpr std::array<EffectParameter, 3> parameters{{
      {"k_mx", "factor on m_x", 1.0, 1.0, 0.0, kUnbounded, log_normal(1.0, 0.3, 0.3, 3.0),
       log_normal(1.0, 0.3, 0.3, 3.0)},
      {"k_my", "factor on m_y", 1.0, 1.0, 0.0, kUnbounded, log_normal(1.0, 0.15, 0.3, 3.0),
       log_normal(1.0, 0.15, 0.3, 3.0)},
      {"k_Jz", "factor on J_z", 1.0, 1.0, 0.0, kUnbounded, log_normal(1.0, 0.15, 0.3, 3.0),
       log_normal(1.0, 0.15, 0.3, 3.0)},
  }};

  T k_mx, k_my, k_Jz;

  AddedMass(const std::array<T, 3>& value, const Ship&) : k_mx(value[0]), k_my(value[1]), k_Jz(value[2]) {}

  void change(ModelParts<T>& parts) const {
    Inertia<T>& inertia = parts.inertia;
    inertia.m_x *= k_mx;
    inertia.m_y *= k_my;
    inertia.I_z += (k_Jz - 1.0) * inertia.added_moment(parts.ship.particulars.L_pp);
  }
};

}  // namespace leeway
