#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace leeway {

/// How rudders follow the angles that are recorded of them. As it stands: at once.
struct RudderResponse {
  double delay_s = 0.0;  ///< they act this much later; below 0 the angles are recorded late, and they have acted before
  double rate_radps = std::numeric_limits<double>::infinity();  ///< and turn no faster
  double lag_s = 0.0;                                           ///< time constant with which they approach

  bool operator==(const RudderResponse&) const = default;
  /// Whether the angle that acts depends on its own past.
  bool has_memory() const { return lag_s > 0.0 || std::isfinite(rate_radps); }

  /// The angle that acts at the end of a short step, from that at its start and the recorded angles, delayed, at its
  /// middle and its end.
  double follow(double angle, double middle, double end, double dt_s) const {
    const double step = lag_s > 0.0 ? -(middle - angle) * std::expm1(-dt_s / lag_s) : end - angle;
    return angle + std::clamp(step, -rate_radps * dt_s, rate_radps * dt_s);
  }
};

}  // namespace leeway
