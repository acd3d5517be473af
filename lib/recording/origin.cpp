#include "recording/origin.hpp"

#include <cmath>

#include <fmt/format.h>

namespace leeway {

std::string Origin::text() const { return fmt::format("x0 = {:.0f} m, y0 = {:.0f} m", x0_m, y0_m); }

std::optional<Origin> far_origin(const std::vector<Trajectory>& recordings, double farther_m) {
  std::optional<Origin> first;
  for (const Trajectory& recording : recordings) {
    if (!recording.has(Channel::x0) || !recording.has(Channel::y0)) continue;
    for (std::size_t i = 0; i < recording.size(); ++i) {
      const double x = recording[Channel::x0][i], y = recording[Channel::y0][i];
      if (std::isnan(x) || std::isnan(y)) continue;
      if (std::hypot(x, y) <= farther_m) return std::nullopt;
      if (!first) first = Origin{std::round(x), std::round(y)};
    }
  }
  return first;
}

void count_from(const Origin& origin, std::vector<Trajectory>& recordings, double sign) {
  for (Trajectory& recording : recordings) {
    for (double& x : recording[Channel::x0]) x -= sign * origin.x0_m;
    for (double& y : recording[Channel::y0]) y -= sign * origin.y0_m;
  }
}

}  // namespace leeway
