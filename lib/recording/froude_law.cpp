#include "recording/froude_law.hpp"

#include <cmath>

namespace leeway {

FroudeLaw::FroudeLaw(double length_ratio) : length(length_ratio), time(std::sqrt(length_ratio)) {}

double FroudeLaw::of(Quantity quantity) const {
  switch (quantity) {
    case Quantity::time:
    case Quantity::speed:
      return time;
    case Quantity::length:
      return length;
    case Quantity::angular_rate:
    case Quantity::revolutions:
      return 1.0 / time;
    case Quantity::angle:
    case Quantity::ratio:
      break;
  }
  return 1.0;
}

Trajectory scaled_down(const Trajectory& recording, const FroudeLaw& scale) {
  Trajectory result = recording;
  for (const ChannelInfo& channel : kChannels)
    for (double& value : result[channel.channel]) value /= scale.of(channel.quantity);
  return result;
}

}  // namespace leeway
