#pragma once

#include "core/units.hpp"
#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct SteadyCurrent {
  static constexpr EffectInfo info{
      .name = "steady-current",
      .number = "E1",
      .sentence = "The water moves as a whole, steadily and everywhere alike.",
      .phrase = "a current of {current_speed_mps} towards {current_set_deg}",
      .formula =
          "V = current_speed (cos set, sin set) in earth axes; nu_r = nu - R(psi)^T V in all equations, eta' = R nu_r "
          "+ V",
      .source = "exact (Galilean); Fossen (2021), Handbook of Marine Craft Hydrodynamics and Motion Control",
      .look_alikes = "heading-bias, unmeasured-wind, earth-force, wave-drift",
      .looks_like = {"unmeasured-wind", "earth-force", "wave-drift"},
      .separating_maneuver = "reciprocal runs, or one full turning circle: its center drifts by V times the period",
      .formula_sd = 0.0,
      .differs_by_recording = true,
      .is_of_surroundings = true,
      .to_record = "the current, or the speed through the water beside that over ground",
      .to_ensemble = EnsembleForm::water_velocity,
  };
  static constexpr std::array<EffectParameter, 2> parameters{{
      {"current_speed_mps", "speed of the water", 0.0, kNone, 0.0, kUnbounded, rayleigh(0.04, 0.15),
       rayleigh(0.3, 1.5)},
      {"current_set_deg", "direction that it flows towards", kNone, kNone, -360.0, 360.0, kAnyDirection, kAnyDirection},
  }};

  Vec2<T> V;  ///< earth axes [m/s]

  SteadyCurrent(const std::array<T, 2>& value, const Ship&) {
    using std::cos, std::sin;
    const T set = value[1] * kDegree;
    V = {value[0] * cos(set), value[0] * sin(set)};
  }

  WaterMotion<T> water(const Situation<T>&) const { return {V, Vec2<T>::Zero(), Mat2<T>::Zero()}; }
};

}  // namespace leeway
