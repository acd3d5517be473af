#pragma once

#include <array>
#include <cstddef>

#include "recording/trajectory.hpp"

namespace leeway {

/// One value per actuator channel (delta [rad], delta_p, delta_s [rad], n_p, n_bt, n_st [1/s]), actual or commanded.
/// Channels that a ship does not have stay zero and are not read by its modules.
template <typename T>
struct Actuators {
  std::array<T, kActuatorChannels.size()> values{};

  static constexpr std::size_t index(Channel channel) {
    return static_cast<std::size_t>(channel) - static_cast<std::size_t>(kActuatorChannels.front());
  }
  T& operator[](Channel channel) { return values[index(channel)]; }
  const T& operator[](Channel channel) const { return values[index(channel)]; }

  template <typename U>
  Actuators<U> cast() const {
    Actuators<U> result;
    for (std::size_t i = 0; i < values.size(); ++i) result.values[i] = U(values[i]);
    return result;
  }
};

/// One actuator of a ship: what it can do, where it stands at the start, and what `mmg-sim random` orders.
/// Angles [rad], revolutions [1/s].
struct Actuator {
  Channel channel = Channel::delta;
  double min = 0.0, max = 0.0;
  double rate = 0.0;             ///< fastest change [rad/s, 1/s^2]
  double time_constant_s = 0.0;  ///< of the approach to the command; 0: the rate limit alone
  double initial = 0.0;
  bool is_optional = false;  ///< a thruster: a recording without its column is of the ship with it idle
  bool is_random = false;    ///< whether random orders are given to it; otherwise it stays at `initial`
  double random_mean = 0.0, random_sd = 0.0;

  bool is_rudder() const { return info(channel).quantity == Quantity::angle; }
  double clip(double command) const { return command < min ? min : command > max ? max : command; }
};

}  // namespace leeway
