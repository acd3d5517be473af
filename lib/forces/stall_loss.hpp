#pragma once

#include <cmath>

namespace leeway {

/// Loss of a rudder's normal force at large angles of attack:
///   1 - depth (1 - exp(-(a - angle)/width))  where a > angle, 1 below;
/// a: acute angle between flow and chord [rad], so that flow from astern stalls like flow from ahead. No hysteresis.
template <typename T>
struct StallLoss {
  T angle, depth, width;  ///< [rad], share, [rad]

  /// along, across: the flow's parts along the chord and across it, in any common unit; not both zero.
  T factor(const T& along, const T& across) const {
    using std::abs, std::atan2, std::exp;
    const T beyond = atan2(T(abs(across)), T(abs(along))) - angle;
    if (!(beyond > T(0.0))) return T(1.0);
    return 1.0 - depth * (1.0 - exp(-beyond / width));
  }
};

}  // namespace leeway
