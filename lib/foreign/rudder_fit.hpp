#pragma once

#include <span>
#include <vector>

#include "foreign/motion_fit.hpp"

namespace leeway::foreign {

inline constexpr double kSignificant = 4.0;  ///< standard deviations of a rudder's response
inline constexpr double kClearSide = 0.8;    ///< share of the turning to one side

/// What turns a ship, as recorded.
struct SteeringColumns {
  std::span<const double> t;                       ///< [s]
  std::span<const double> r;                       ///< positive to starboard, in any unit
  std::span<const double> speed;                   ///< in any unit; empty: not known
  std::vector<std::span<const double>> rudders;    ///< in any unit
  std::vector<std::span<const double>> thrusters;  ///< revolutions in any unit
};

/// To which side a rudder turns the ship, by two ways that do not share their faults.
struct RudderResponse {
  double b = 0.0;             ///< of r' = a U r + b U^2 delta + ...; > 0: turns to starboard
  double significance = 0.0;  ///< |b| by its standard deviation
  double held = 0.0;          ///< -1 to 1: how much of the turning under a held rudder goes to its positive side

  /// 1: positive angles turn the ship to starboard; -1: to port; 0: it does not show. Where the two contradict each
  /// other, the side to which the ship turns while the rudder is held counts, if the rudder is alone.
  double side(bool is_alone) const;
  bool is_contradictory() const;
};

/// One response for each rudder, of all together: r' = a U r + sum of b_i U^2 delta_i + sum of c_j n_j |n_j| + d U^2 by
/// least squares over windows; with 1 in place of U and U^2 where that fits better, as for rudders in a slipstream at
/// low speed. Standard deviations are those of blocks of windows, since what a linear law leaves over lasts.
std::vector<RudderResponse> fit_rudders(const Windows& windows, const SteeringColumns& columns);

}  // namespace leeway::foreign
