#pragma once

#include "core/units.hpp"
#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct Anemometer {
  static constexpr EffectInfo info{
      .name = "anemometer",
      .number = "E9",
      .sentence =
          "The anemometer on board reads too much or too little, or is turned: another wind blew than is recorded.",
      .phrase =
          "an anemometer error: it reads {anemometer_scale%} too {anemometer_scale?much|little}; it is turned by "
          "{anemometer_angle_deg}",
      .formula =
          "apparent wind as measured w_m = R(psi)' w_T,recorded + (u, v_m), over ground; w_A = Rot(-anemometer_angle) "
          "w_m / anemometer_scale; the model gets w_T = R(psi) (w_A - (u, v_m)); vectors pointing to where the wind "
          "comes from. Nothing where no wind is recorded",
      .source =
          "geometry of a true wind that was made from a faulty apparent wind; size: Moat et al. (2004) for ships' "
          "bridges",
      .look_alikes = "windage (kX by kY), unmeasured-wind",
      .looks_like = {"windage", "unmeasured-wind"},
      .separating_maneuver = "eight headings in a steady wind, or a circle at low speed",
      .to_record = "the wind by a second anemometer",
  };
  static constexpr std::array<EffectParameter, 2> parameters{{
      {"anemometer_scale", "measured by actual speed of the apparent wind: 1.1 reads 10 % too much", 1.0, 1.0, 1e-2,
       100.0, log_normal(1.0, 0.15, 0.3, 3.0), log_normal(1.0, 0.15, 0.3, 3.0)},
      {"anemometer_angle_deg", "measured less actual direction of the apparent wind, clockwise", 0.0, 0.0, -360.0,
       360.0, normal(0.0, 5.0, -30.0, 30.0), normal(0.0, 5.0, -30.0, 30.0)},
  }};

  T c, s;  ///< of w_A = (c, s; -s, c) w_m

  Anemometer(const std::array<T, 2>& value, const Ship& ship) {
    using std::cos, std::sin;
    if (!ship.modules->wind) throw EffectNotApplicable("the ship has no wind module");
    c = cos(value[1] * kDegree) / value[0];
    s = sin(value[1] * kDegree) / value[0];
  }

  Vec2<T> wind(const Situation<T>& at) const {
    if (at.recorded_wind(0) == T(0.0) && at.recorded_wind(1) == T(0.0)) return Vec2<T>::Zero();
    const Vec2<T> w_m = at.to_ship(at.recorded_wind) + at.nu_ground.template head<2>();
    return at.to_earth({(c - 1.0) * w_m(0) + s * w_m(1), (c - 1.0) * w_m(1) - s * w_m(0)});
  }
};

}  // namespace leeway
