#pragma once

#include "effects/effect.hpp"
#include "effects/wall.hpp"

namespace leeway {

template <typename T>
struct Fender {
  static constexpr EffectInfo info{
      .name = "fender",
      .number = "E44",
      .sentence = "The ship leans on a fendered quay, which pushes back where the hull touches.",
      .phrase = "a fendered quay {wall_distance_m} away towards {wall_direction_deg}",
      .formula =
          "hull: a box with corners at (+-L/2, +-B/2); wall as bank, e towards it; at each corner p with penetration c "
          "= p . e - wall_distance > 0 a force -e stiffness c max(0, 1 + damping c'); no force before contact, no "
          "friction",
      .source =
          "elastic contact; damping after Hunt & Crossley (1975), J. Applied Mechanics 42, 440-445: without a step in "
          "the force; of an impact speed v about 1 - 2/3 damping v comes back; the box is ours",
      .look_alikes = "bank, mooring, tug",
      .looks_like = {"bank", "mooring", "tug"},
      .separating_maneuver = "none is needed: there is a threshold in position, and the speed does not matter",
      .bound_to = BoundTo::place,
      .is_of_surroundings = true,
      .search = SearchStart::contact,
  };
  static constexpr std::array<EffectParameter, 4> parameters{{
      Wall<T>::kDistance,
      Wall<T>::kDirection,
      {"stiffness_npm", "of the fenders at one corner of the hull", 0.0, kNone, 0.0, kUnbounded,
       log_normal(200.0, 1.5, 0.0, 1e5), log_normal(5e5, 1.5, 0.0, 2.5e8)},
      {"damping_spm", "added share of the elastic force by speed of penetration", kNone, 0.0, 0.0, kUnbounded,
       uniform(0.0, 10.0), uniform(0.0, 1.4)},
  }};

  Wall<T> wall;
  T stiffness, damping;
  double x, y;  ///< of the corner at the bow to starboard

  Fender(const std::array<T, 4>& value, const Ship& ship)
      : wall(value[0], value[1]),
        stiffness(value[2]),
        damping(value[3]),
        x(0.5 * ship.particulars.L_pp),
        y(0.5 * ship.particulars.B) {}

  Vec3<T> force(const Situation<T>& at) const {
    const Vec2<T> e = at.to_ship(wall.towards);
    const T before = wall.distance_to(at.eta.template head<2>());
    const T &u = at.nu_ground(0), &v = at.nu_ground(1), &r = at.nu_ground(2);
    Vec3<T> sum = Vec3<T>::Zero();
    for (const double x_c : {x, -x})
      for (const double y_c : {y, -y}) {
        const T c = x_c * e(0) + y_c * e(1) - before;
        if (!(c > T(0.0))) continue;
        const T damped = 1.0 + damping * ((u - r * y_c) * e(0) + (v + r * x_c) * e(1));
        if (!(damped > T(0.0))) continue;
        const T F = stiffness * c * damped;
        sum -= Vec3<T>(F * e(0), F * e(1), F * (x_c * e(1) - y_c * e(0)));
      }
    return sum;
  }
};

}  // namespace leeway
