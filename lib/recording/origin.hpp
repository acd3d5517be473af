#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/trajectory.hpp"

/// Where positions are counted from. Grid coordinates (UTM) count from thousands of kilometers away, where what depends
/// on the place has no digits left and a current that changes with it has no bounds.
namespace leeway {

struct Origin {
  double x0_m = 0.0, y0_m = 0.0;
  /// "x0 = 5933120 m, y0 = 568440 m".
  std::string text() const;
};

/// The first recorded position, to the meter, if all positions are farther than so much from the origin.
std::optional<Origin> far_origin(const std::vector<Trajectory>& recordings, double farther_m);

/// Positions are counted from there from now on; sign -1: no longer.
void count_from(const Origin& origin, std::vector<Trajectory>& recordings, double sign = 1.0);

}  // namespace leeway
