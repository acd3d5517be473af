#pragma once

#include <array>
#include <vector>

#include "core/random.hpp"
#include "core/types.hpp"

namespace leeway::ensemble {

/// A stationary normal process with the autocovariance sd^2 exp(-|t| / tau).
struct OrnsteinUhlenbeck {
  double sd = 0.0;     ///< [m/s^2 or rad/s^2]
  double tau_s = 1.0;  ///< > 0

  friend bool operator==(const OrnsteinUhlenbeck&, const OrnsteinUhlenbeck&) = default;
};

/// Accelerations of u, v_m, r that no model knows, gusts and waves say: in each axis a sum of independent processes.
struct Disturbance {
  std::array<std::vector<OrnsteinUhlenbeck>, 3> axes;

  bool is_zero() const;

  friend bool operator==(const Disturbance&, const Disturbance&) = default;
};

/// One path of a disturbance at equal steps, exact at their times; each value acts for a step.
class DisturbancePath {
 public:
  /// Starts stationary. The disturbance outlives the path.
  DisturbancePath(const Disturbance& disturbance, double dt_s, RandomStream& random);
  /// (u', v_m' [m/s^2], r' [rad/s^2]) of the step that begins now; then a step passes.
  Vec3<double> next(RandomStream& random);

 private:
  struct Component {
    int axis;
    double value, kept, renewed;  // value := kept * value + renewed * N(0, 1)
  };
  std::vector<Component> components_;
};

}  // namespace leeway::ensemble
