#pragma once

#include <cmath>
#include <optional>
#include <string_view>

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
  static constexpr std::string_view reference = "another curvature of C_N over the angle of attack (ours)";
  static constexpr double kSine35 = 0.57357643635104609;  // sin 35 deg

  T k_35 = T(1.0);  ///< factor at an angle of 35 deg; from 0, where it is 1, it goes with the sine
  T k_90 = T(1.0);  ///< further factor across the flow; from 35 deg, where it is 1, it goes with the sine
  std::optional<StallLoss<T>> stall;

  /// along, across: the flow's parts along the chord and across it; speed > 0: the root of the sum of their squares.
  T factor(const T& along, const T& across, const T& speed) const {
    using std::abs;
    const T sine = abs(across) / speed;
    T k = 1.0 + (k_35 - 1.0) * (sine / kSine35);
    if (sine > T(kSine35)) k *= 1.0 + (k_90 - 1.0) * ((sine - kSine35) / (1.0 - kSine35));
    if (stall) k *= stall->factor(along, across);
    return k;
  }
};

}  // namespace leeway
