#include "recording/trajectory.hpp"

#include <cmath>

#include "core/units.hpp"

namespace leeway {

std::string column_name(Channel channel) {
  const ChannelInfo& i = info(channel);
  return std::string(i.name) + (i.unit.empty() ? "" : "_" + std::string(i.unit));
}

std::string si_name(Channel channel) {
  const ChannelInfo& i = info(channel);
  switch (i.quantity) {
    case Quantity::angle:
      return std::string(i.name) + "_rad";
    case Quantity::angular_rate:
      return std::string(i.name) + "_radps";
    default:
      return column_name(channel);
  }
}

void unwrap(std::vector<double>& angle) {
  double previous = kMissing, turns = 0.0;
  for (double& a : angle) {
    if (std::isnan(a)) continue;
    const double raw = a;
    if (!std::isnan(previous)) turns -= std::round((raw - previous) / (2.0 * kPi));
    previous = raw;
    a = raw + turns * 2.0 * kPi;
  }
}

}  // namespace leeway
