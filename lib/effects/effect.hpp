#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "core/types.hpp"
#include "effects/rudder_response.hpp"
#include "forces/inertia.hpp"
#include "forces/registry.hpp"

/// Physics that a model can lack. Each effect is one header: what it is, its formula, its parameters with their priors,
/// and the code. An effect does what it has members for; registry.hpp calls them:
///
///   void change(ModelParts<T>&)                       coefficients, once, when the model is made
///   void act(Actuators<T>&) const                     what acts instead of what the recording says
///   Vec2<T> wind(const Situation<T>&) const           added to the true wind, from-vector in earth axes [m/s]
///   WaterMotion<T> water(const Situation<T>&) const   added to the motion of the water at the ship's place
///   Vec3<T> force(const Situation<T>&) const          added at midship (X [N], Y [N], N [N m])
///   void slow(RudderResponse&) const                  the rudders follow late what is recorded of them; with T =
///   double
///                                                     alone: it is done to the recorded angles before a step
///
/// At zero strength an effect changes nothing, to the last bit.
namespace leeway {

/// What is known about a parameter before any recording was seen. Median and sd in the parameter's unit, the sd of a
/// log-normal in natural logarithms; bounds are hard.
struct Prior {
  enum class Kind { normal, log_normal, rayleigh, uniform } kind;
  double median, sd, low, high;
};
constexpr Prior normal(double median, double sd, double low, double high) {
  return {Prior::Kind::normal, median, sd, low, high};
}
constexpr Prior log_normal(double median, double log_sd, double low, double high) {
  return {Prior::Kind::log_normal, median, log_sd, low, high};
}
/// The length of a vector whose two components are normal with this sd and mean 0.
constexpr Prior rayleigh(double sd, double high) {
  return {Prior::Kind::rayleigh, sd * 1.1774100225154747 /* sqrt(2 ln 2) */, sd, 0.0, high};
}
constexpr Prior uniform(double low, double high) {
  return {Prior::Kind::uniform, 0.5 * (low + high), 0.28867513459481287 * (high - low), low, high};
}
inline constexpr Prior kAnyDirection = uniform(0.0, 360.0);
constexpr bool is_direction(const Prior& prior) {
  return prior.kind == Prior::Kind::uniform && prior.high - prior.low >= 360.0;
}

/// One parameter of an effect, in the unit that its name carries.
struct EffectParameter {
  std::string_view name, meaning;
  double off;        ///< the value at which the effect vanishes; NaN where no finite value does
  double otherwise;  ///< taken where the ship JSON does not give it; NaN: it must be given
  double low, high;  ///< what makes sense at all
  Prior at_3m, at_150m;

  /// Of a ship of this length between perpendiculars [m]: longer ones than 20 m take the prior for 150 m.
  constexpr const Prior& prior(double L_pp) const { return L_pp > 20.0 ? at_150m : at_3m; }
};
inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

struct EffectInfo {
  std::string_view name, number;  ///< as in the ship JSON; in the catalogue of missing physics
  std::string_view sentence;      ///< what it is, to a person
  std::string_view formula, source;
  std::string_view look_alikes, separating_maneuver;
  /// How well the formula itself is known, relative: intervals of strengths and directions have it besides (ours:
  /// authors' formulas for one thing differ by as much and more).
  double formula_sd = 0.1;
};

/// What effects may change when the model is made.
template <typename T>
struct ModelParts {
  const Ship& ship;
  Inertia<T>& inertia;
  ForceModules<T>& modules;
};

/// What effects may look at during a run: water() at time and pose alone, wind() also at the velocity over ground and
/// the recorded wind, force() at all. Frames and signs as in docs/conventions.md.
template <typename T>
struct Situation {
  double t_s;
  Vec3<T> eta;            ///< (x0, y0 [m], psi [rad])
  T cos_psi, sin_psi;     ///< of the heading
  Vec3<T> nu_ground;      ///< (u, v_m [m/s], r [rad/s])
  Vec3<T> nu_water;       ///< the same through the water; r less the water's turn
  Vec2<T> recorded_wind;  ///< true wind as the recording has it, from-vector in earth axes [m/s]; 0: none is recorded
  const Actuators<T>* actuators = nullptr;  ///< as they act
  Vec2<T> to_ship(const Vec2<T>& earth) const {
    return {cos_psi * earth(0) + sin_psi * earth(1), -sin_psi * earth(0) + cos_psi * earth(1)};
  }
  Vec2<T> to_earth(const Vec2<T>& ship) const {
    return {cos_psi * ship(0) - sin_psi * ship(1), sin_psi * ship(0) + cos_psi * ship(1)};
  }
};

/// The water about the ship, in earth axes: its velocity V [m/s], how that changes with time at a fixed place [m/s^2],
/// and from place to place, dV_i/dx_j [1/s].
template <typename T>
struct WaterMotion {
  Vec2<T> velocity = Vec2<T>::Zero(), rate = Vec2<T>::Zero();
  Mat2<T> gradient = Mat2<T>::Zero();

  /// dV/dt along the path of a ship that moves over ground with this velocity in earth axes [m/s^2].
  Vec2<T> along_path(const Vec2<T>& over_ground) const { return rate + gradient * over_ground; }
  /// The yaw rate that a ship has in water at rest where the cross flow changes along it as it does here [rad/s]:
  /// e_y' R' (dV/dp) R e_x, to be taken off r in the hydrodynamic forces. Source: Thomasson & Woolsey (2013), IEEE J.
  /// Oceanic Engineering 38, put the flow's gradient into the angular rate of the viscous terms.
  T turn(const Situation<T>& at) const {
    const T &c = at.cos_psi, &s = at.sin_psi;
    return c * (gradient(1, 0) * c + gradient(1, 1) * s) - s * (gradient(0, 0) * c + gradient(0, 1) * s);
  }
};

/// Thrown by the constructor of an effect that needs something that the ship does not have.
struct EffectNotApplicable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace leeway
