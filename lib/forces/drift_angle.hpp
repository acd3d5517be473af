#pragma once

#include <cmath>

namespace leeway {

/// The drift angle beta = atan2(-v_m, u) [rad] for u >= 0; positive where the water comes from port. Not at rest.
/// Below 45 deg by atan, which costs half of atan2 and a maneuver asks for it often.
template <typename T>
T drift_angle(const T& u, const T& v_m) {
  using std::abs, std::atan, std::atan2;
  return abs(v_m) < u ? T(atan(-v_m / u)) : T(atan2(T(-v_m), u));
}

}  // namespace leeway
