#pragma once

#include "effects/effect.hpp"
#include "effects/wall.hpp"

namespace leeway {

template <typename T>
struct Bank {
  static constexpr EffectInfo info{
      .name = "bank",
      .number = "E5",
      .sentence = "A bank or quay alongside sucks the passing ship towards it and pushes its bow away.",
      .phrase = "a bank {wall_distance_m} away towards {wall_direction_deg}",
      .formula =
          "D = wall_distance - (x0, y0) . e, e = (cos wall_direction, sin wall_direction), s = sine of the angle from "
          "the bow to e (1: wall abeam to starboard); D_w = B/2 + (D - B/2 + sqrt((D - B/2)^2 + (B/20)^2))/2, f = "
          "(B/(2 D_w))^n; Y = s (rho/2) L d u^2 C_Y f, N = -s (rho/2) L^2 d u |u| C_N f, u through the water",
      .source =
          "form ours, in the manner of Norrbin (1974), 10th Symposium on Naval Hydrodynamics; s for other than "
          "parallel courses; D_w keeps D above B/2, where the ship would touch; the factors of depth and thrust are "
          "part of C_Y and C_N",
      .look_alikes = "body-force, fender, sheared-current",
      .looks_like = {"body-force", "fender", "sheared-current"},
      .separating_maneuver = "passing the same wall at two speeds and two distances",
      .bound_to = BoundTo::place,
      .is_of_surroundings = true,
      .search = SearchStart::wall,
  };
  static constexpr std::array<EffectParameter, 5> parameters{{
      Wall<T>::kDistance,
      Wall<T>::kDirection,
      {"C_Y", "suction, at D = B/2", 0.0, kNone, -kUnbounded, kUnbounded, log_normal(0.05, 0.8, 0.0, 1.0),
       log_normal(0.05, 0.8, 0.0, 1.0)},
      {"C_N", "moment bow away from the wall, at D = B/2", 0.0, kNone, -kUnbounded, kUnbounded,
       log_normal(0.01, 0.8, 0.0, 0.2), log_normal(0.01, 0.8, 0.0, 0.2)},
      {"n", "power of the distance", kNone, 2.0, 0.1, 10.0, uniform(1.0, 3.0), uniform(1.0, 3.0)},
  }};

  Wall<T> wall;
  T Y0, N0;  ///< by u^2 at D = B/2 [N s^2/m^2, N s^2/m]
  T n;
  double B;

  Bank(const std::array<T, 5>& value, const Ship& ship) : wall(value[0], value[1]), n(value[4]), B(ship.particulars.B) {
    const Particulars& p = ship.particulars;
    const double q = 0.5 * p.rho * p.L_pp * p.d;
    Y0 = q * value[2];
    N0 = q * p.L_pp * value[3];
  }

  Vec3<T> force(const Situation<T>& at) const {
    using std::abs, std::pow, std::sqrt;
    const T gap = wall.distance_to(at.eta.template head<2>()) - 0.5 * B;
    const T D = 0.5 * B + 0.5 * (gap + sqrt(gap * gap + 0.0025 * B * B));
    const T sf = at.to_ship(wall.towards)(1) * pow(0.5 * B / D, n);
    const T& u = at.nu_water(0);
    return {T(0.0), Y0 * u * u * sf, -N0 * u * abs(u) * sf};
  }
};

}  // namespace leeway
