#pragma once

#include "recording/trajectory.hpp"

namespace leeway {

/// The sizes of one ship by those of another one of the same shape. Froude's law: with lengths as L, times and speeds
/// go as sqrt(L), so that accelerations are the same.
struct FroudeLaw {
  double length = 1.0, time = 1.0;

  FroudeLaw() = default;
  ///   length_ratio  > 0, length of the one ship by that of the other
  explicit FroudeLaw(double length_ratio);
  /// A quantity of the one ship, by that of the other.
  double of(Quantity quantity) const;
};

/// What the one ship recorded, in the lengths and times of the other: all channels divided by the scale.
Trajectory scaled_down(const Trajectory& recording, const FroudeLaw& scale);

}  // namespace leeway
