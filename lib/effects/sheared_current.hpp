#pragma once

#include "core/units.hpp"
#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct ShearedCurrent {
  static constexpr EffectInfo info{
      .name = "sheared-current",
      .number = "E3",
      .sentence = "The water moves steadily, but not everywhere alike: its velocity changes from place to place.",
      .phrase =
          "a current that changes from place to place: {current_speed_mps} towards {current_set_deg} at the origin",
      .formula =
          "V = current_speed (cos set, sin set) + G (x0, y0), G = (dVx_dx, dVx_dy; dVy_dx, dVy_dy), x north (x0) and y "
          "east (y0); equations of motion as steady-current with dV/dt = G (x0', y0'); in the hydrodynamic forces r - "
          "e_y' R(psi)' G R(psi) e_x for r",
      .source =
          "kinematics: exact; the flow's gradient as a yaw rate: Thomasson & Woolsey (2013), IEEE J. Oceanic "
          "Engineering 38, here along the hull alone and without the gradient's part in the added-mass terms (ours)",
      .look_alikes = "bank, steady-current where few places were visited",
      .looks_like = {"bank", "steady-current"},
      .separating_maneuver = "crossing the shear twice, in both directions",
      .formula_sd = 0.0,
      .is_of_surroundings = true,
      .to_record = "the current, or the speed through the water beside that over ground",
  };
  static constexpr Prior kGradient3 = normal(0.0, 0.005, -0.05, 0.05), kGradient150 = normal(0.0, 7e-4, -7e-3, 7e-3);
  static constexpr std::array<EffectParameter, 6> parameters{{
      {"dVx_dx_1ps", "change of the northward velocity to the north", 0.0, 0.0, -kUnbounded, kUnbounded, kGradient3,
       kGradient150},
      {"dVx_dy_1ps", "change of the northward velocity to the east", 0.0, 0.0, -kUnbounded, kUnbounded, kGradient3,
       kGradient150},
      {"dVy_dx_1ps", "change of the eastward velocity to the north", 0.0, 0.0, -kUnbounded, kUnbounded, kGradient3,
       kGradient150},
      {"dVy_dy_1ps", "change of the eastward velocity to the east", 0.0, 0.0, -kUnbounded, kUnbounded, kGradient3,
       kGradient150},
      {"current_speed_mps", "speed of the water at the origin of x0, y0", 0.0, 0.0, 0.0, kUnbounded,
       rayleigh(0.04, 0.15), rayleigh(0.3, 1.5)},
      {"current_set_deg", "direction that it flows towards there", kNone, 0.0, -360.0, 360.0, kAnyDirection,
       kAnyDirection},
  }};

  Vec2<T> V;  ///< at the origin, earth axes [m/s]
  Mat2<T> G;  ///< [1/s]

  ShearedCurrent(const std::array<T, 6>& value, const Ship&) {
    using std::cos, std::sin;
    const T set = value[5] * kDegree;
    V = {value[4] * cos(set), value[4] * sin(set)};
    G << value[0], value[1], value[2], value[3];
  }

  WaterMotion<T> water(const Situation<T>& at) const { return {V + G * at.eta.template head<2>(), Vec2<T>::Zero(), G}; }
};

}  // namespace leeway
