#pragma once

#include "core/units.hpp"
#include "core/wind.hpp"
#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct UnmeasuredWind {
  static constexpr EffectInfo info{
      .name = "unmeasured-wind",
      .number = "E10",
      .sentence =
          "A steady wind blows that the recording does not hold; it comes to the wind that it does hold, if any.",
      .phrase = "an unrecorded wind of {wind_speed_mps} from {wind_dir_deg}",
      .formula =
          "w_T = w_T,recorded + wind_speed (cos dir, sin dir), vectors pointing to where the wind comes from; then the "
          "wind module",
      .source = "Fujiwara, Ueno & Nimura (1998), J. SNAJ 183, 77-90, through the ship's wind module",
      .look_alikes = "wave-drift, earth-force, steady-current",
      .looks_like = {"wave-drift", "earth-force", "steady-current"},
      .separating_maneuver = "different ship speeds, reciprocal runs, and stopping to drift",
      .differs_by_recording = true,
      .is_of_surroundings = true,
      .to_record = "the wind",
      .search = SearchStart::compass,
      .to_ensemble = EnsembleForm::wind_velocity,
  };
  static constexpr std::array<EffectParameter, 2> parameters{{
      {"wind_speed_mps", "speed of the wind that is not in the recording", 0.0, kNone, 0.0, kUnbounded,
       rayleigh(2.0, 10.0), rayleigh(6.0, 40.0)},
      {"wind_dir_deg", "direction that it comes from", kNone, kNone, -360.0, 360.0, kAnyDirection, kAnyDirection},
  }};

  Vec2<T> w;  ///< from-vector, earth axes [m/s]

  UnmeasuredWind(const std::array<T, 2>& value, const Ship& ship)
      : w(wind_from_vector<T>(value[0], value[1] * kDegree)) {
    if (!ship.modules->wind) throw EffectNotApplicable("the ship has no wind module");
  }

  Vec2<T> wind(const Situation<T>&) const { return w; }
};

}  // namespace leeway
