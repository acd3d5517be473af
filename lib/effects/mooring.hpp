#pragma once

#include "effects/effect.hpp"

namespace leeway {

template <typename T>
struct Mooring {
  static constexpr EffectInfo info{
      .name = "mooring",
      .number = "E43",
      .sentence = "A line or a tether holds the ship to a fixed point.",
      .phrase = "a line to a fixed point at x0 = {anchor_x_m}; y0 = {anchor_y_m}",
      .formula =
          "q from the attachment on the ship to the anchor, F = stiffness max(0, |q| - slack_length) along q; X, Y in "
          "ship axes, N = attach_x Y - attach_y X",
      .source = "statics of an elastic line without weight",
      .look_alikes = "tug, fender, earth-force where the ship moves little",
      .looks_like = {"tug", "fender", "earth-force"},
      .separating_maneuver = "none is needed: it pulls to one place, more from further away; with slack, not near it",
      .bound_to = BoundTo::place,
      .is_of_surroundings = true,
      .to_record = "the force in the line",
      .search = SearchStart::anchor,
  };
  static constexpr std::array<EffectParameter, 6> parameters{{
      {"anchor_x_m", "x0 of the anchor", kNone, kNone, -kUnbounded, kUnbounded, uniform(-30.0, 30.0),
       uniform(-1500.0, 1500.0), ParameterRole::anchor_x},
      {"anchor_y_m", "y0 of the anchor", kNone, kNone, -kUnbounded, kUnbounded, uniform(-30.0, 30.0),
       uniform(-1500.0, 1500.0), ParameterRole::anchor_y},
      {"stiffness_npm", "tension by stretch", 0.0, kNone, 0.0, kUnbounded, log_normal(0.2, 1.5, 0.0, 1e3),
       log_normal(500.0, 1.5, 0.0, 2.5e6)},
      {"slack_length_m", "length at which the line goes taut", kNone, 0.0, 0.0, kUnbounded, uniform(0.0, 15.0),
       uniform(0.0, 750.0), ParameterRole::slack},
      {"attach_x_m", "attachment ahead of midship", kNone, 0.0, -kUnbounded, kUnbounded, uniform(-1.5, 1.5),
       uniform(-75.0, 75.0)},
      {"attach_y_m", "attachment to starboard", kNone, 0.0, -kUnbounded, kUnbounded, uniform(-0.25, 0.25),
       uniform(-12.5, 12.5)},
  }};

  Vec2<T> anchor, attach;  ///< earth axes; ship axes
  T stiffness, slack;

  Mooring(const std::array<T, 6>& value, const Ship&)
      : anchor(value[0], value[1]), attach(value[4], value[5]), stiffness(value[2]), slack(value[3]) {}

  Vec3<T> force(const Situation<T>& at) const {
    using std::sqrt;
    const Vec2<T> q = at.to_ship(anchor - at.eta.template head<2>()) - attach;
    const T q2 = q(0) * q(0) + q(1) * q(1);
    if (q2 < slack * slack) return Vec3<T>::Zero();
    T k = stiffness;
    if (q2 > T(0.0)) k -= stiffness * slack / sqrt(q2);
    const T X = k * q(0), Y = k * q(1);
    return {X, Y, attach(0) * Y - attach(1) * X};
  }
};

}  // namespace leeway
