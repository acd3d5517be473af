#pragma once

#include "recording/froude_law.hpp"

/// Thresholds that are lengths or times are stated for a ship of 3 m (kPolicy.reference_length_m). Those of other
/// ships follow from Froude's law.
namespace leeway::gap {

/// Of a ship, by those of the ship of 3 m.
struct FroudeScale : leeway::FroudeLaw {
  FroudeScale() = default;
  /// Of a ship of this length between perpendiculars [m].
  explicit FroudeScale(double L_pp);
};

/// A recording as the ship of 3 m would have made it: all channels in its lengths and times.
inline Trajectory at_3m(const Trajectory& recording, const FroudeScale& scale) { return scaled_down(recording, scale); }

}  // namespace leeway::gap
