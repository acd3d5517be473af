#pragma once

#include <cmath>

#include "core/types.hpp"

namespace leeway {

/// Wind as a vector that points to where it comes *from*, earth axes [m/s]: speed U_T, direction xi_T (0 from +x0).
template <typename T>
Vec2<T> wind_from_vector(const T& speed, const T& direction) {
  using std::cos, std::sin;
  return {speed * cos(direction), speed * sin(direction)};
}

/// Apparent wind in ship axes, again pointing to where it comes from [m/s]: w'_A = R(psi)^T w_T + (u, v_m).
/// The sign differs from the printed equation of the ensemble paper, whose own definition of "from" needs this one:
/// a ship going ahead in calm air feels the wind from the bow (docs/conventions.md).
///   true_wind  as wind_from_vector, earth axes [m/s];  psi [rad];  u, v_m over ground [m/s]
template <typename T>
Vec2<T> apparent_wind(const Vec2<T>& true_wind, const T& psi, const T& u, const T& v_m) {
  using std::cos, std::sin;
  const T c = cos(psi), s = sin(psi);
  return {c * true_wind(0) + s * true_wind(1) + u, -s * true_wind(0) + c * true_wind(1) + v_m};
}

/// The inverse of apparent_wind: true wind in earth axes [m/s] from the apparent wind in ship axes.
template <typename T>
Vec2<T> true_wind_from_apparent(const Vec2<T>& apparent, const T& psi, const T& u, const T& v_m) {
  using std::cos, std::sin;
  const T c = cos(psi), s = sin(psi), x = apparent(0) - u, y = apparent(1) - v_m;
  return {c * x - s * y, s * x + c * y};
}

}  // namespace leeway
