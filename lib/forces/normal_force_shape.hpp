#pragma once

#include <cmath>
#include <optional>

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

/// What a rudder's normal force differs by from its module's curve over the angle of attack; nothing as it is shipped.
template <typename T>
struct NormalForceShape {
  static constexpr double kSine35 = 0.57357643635104609;  // sin 35 deg

  T k_35 = T(1.0);  ///< factor at an angle of 35 deg; in between it goes with the sine, at 0 it is 1
  std::optional<StallLoss<T>> stall;

  /// along, across: the flow's parts along the chord and across it; speed > 0: the root of the sum of their squares.
  T factor(const T& along, const T& across, const T& speed) const {
    using std::abs;
    T k = 1.0 + (k_35 - 1.0) * (abs(across) / (kSine35 * speed));
    if (stall) k *= stall->factor(along, across);
    return k;
  }
};

}  // namespace leeway
