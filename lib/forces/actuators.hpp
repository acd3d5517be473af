#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "core/units.hpp"
#include "recording/trajectory.hpp"

namespace leeway {

/// One value per actuator channel (delta, delta_p, delta_s, az1, az2 [rad], n_p, n_bt, n_st, n_az1, n_az2 [1/s]),
/// actual or commanded. Channels that a ship does not have stay zero and are not read by its modules.
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

/// Actuators with the sines and cosines of the rudder angles, which are dear, so that the stages of a time step share
/// them where the rudders do not move.
template <typename T>
struct ActingActuators {
  static constexpr std::array kRudders{Channel::delta, Channel::delta_p, Channel::delta_s};
  Actuators<T> actuators;
  std::array<T, kRudders.size()> sines, cosines;

  ActingActuators(const Actuators<T>& values) : actuators(values) {
    using std::cos, std::sin;
    for (std::size_t i = 0; i < kRudders.size(); ++i) {
      const T& angle = actuators[kRudders[i]];
      // The channels that a ship does not have are zero. An autodiff scalar may have a derivative there.
      const bool is_zero = std::is_floating_point_v<T> && angle == T(0.0);
      sines[i] = is_zero ? angle : T(sin(angle));
      cosines[i] = is_zero ? T(1.0) : T(cos(angle));
    }
  }
  /// For `values`, taken from `known` where they are the same.
  ActingActuators(const Actuators<T>& values, const ActingActuators& known) : ActingActuators(shared(values, known)) {}

  const T& operator[](Channel channel) const { return actuators[channel]; }
  const T& sine(Channel rudder) const { return sines[index(rudder)]; }
  const T& cosine(Channel rudder) const { return cosines[index(rudder)]; }

 private:
  static constexpr std::size_t index(Channel rudder) { return Actuators<T>::index(rudder); }
  static ActingActuators shared(const Actuators<T>& values, const ActingActuators& known) {
    return std::ranges::equal(values.values, known.actuators.values, is_same) ? known : ActingActuators(values);
  }
  // Autodiff scalars also in their derivatives.
  static bool is_same(const T& a, const T& b) {
    if constexpr (std::is_floating_point_v<T>)
      return a == b;
    else
      return a.a == b.a && a.v == b.v;
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
  double n_at_pitch_current_1 = 0.0;  ///< [1/s], of a bow thruster: what i_bt = 1 stands for; 0: nothing is stated

  bool is_rudder() const { return info(channel).role == Role::rudder; }
  bool is_propulsion() const { return info(channel).role == Role::propulsion; }
  bool is_thruster() const { return info(channel).role == Role::thruster; }
  /// Without limits: a turn more is the same.
  bool turns_freely() const { return info(channel).role == Role::azimuth; }
  bool is_angle() const { return info(channel).quantity == Quantity::angle; }  ///< [rad]; otherwise [1/s]
  /// What its values span; a turn where it turns freely.
  double range() const { return turns_freely() ? 2.0 * kPi : max - min; }
  double clip(double command) const { return command < min ? min : command > max ? max : command; }
};

}  // namespace leeway
