#include "ship/pitch_current.hpp"

#include <fmt/format.h>

#include "core/errors.hpp"

namespace leeway {
namespace {

// Revolutions at i_bt = 1 [1/s]; 0 where the ship has none.
double revolutions_at_1(const Ship& ship) {
  const Actuator* thruster = ship.find_actuator(Channel::n_bt);
  return thruster != nullptr ? thruster->n_at_pitch_current_1 : 0.0;
}

}  // namespace

void add_revolutions(std::vector<Trajectory>& recordings, const Ship& ship) {
  if (ship.find_actuator(Channel::n_bt) == nullptr) return;
  const double n = revolutions_at_1(ship);
  for (Trajectory& recording : recordings) {
    if (!recording.has(Channel::i_bt) || recording.has(Channel::n_bt)) continue;
    if (n == 0.0)
      throw InputError(
          recording.file, 1, "",
          fmt::format("has '{}' and no '{}', but the ship '{}' does not state what the pitch current stands "
                      "for: expected 'pitch_current' in its actuator n_bt",
                      column_name(Channel::i_bt), column_name(Channel::n_bt), ship.name));
    recording[Channel::n_bt] = recording[Channel::i_bt];
    for (double& value : recording[Channel::n_bt]) value *= n;
  }
}

void add_pitch_current(Trajectory& trajectory, const Ship& ship) {
  const double n = revolutions_at_1(ship);
  if (n == 0.0)
    throw InputError(ship.file, 0, "/actuators",
                     fmt::format("the ship '{}' has no actuator n_bt with a 'pitch_current', so that '{}' is not known",
                                 ship.name, column_name(Channel::i_bt)));
  trajectory[Channel::i_bt] = trajectory[Channel::n_bt];
  for (double& value : trajectory[Channel::i_bt]) value /= n;
}

bool knows(const Ship& ship, Channel channel) {
  return ship.find_actuator(channel) != nullptr || (channel == Channel::i_bt && revolutions_at_1(ship) > 0.0);
}

double value_of(Channel channel, const Actuators<double>& actuators, const Ship& ship) {
  if (channel == Channel::i_bt && revolutions_at_1(ship) > 0.0)
    return actuators[Channel::n_bt] / revolutions_at_1(ship);
  return actuators[channel];
}

}  // namespace leeway
