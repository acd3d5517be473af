#pragma once

#include <vector>

#include "ship/ship.hpp"

namespace leeway {

/// A bow thruster of controllable pitch turns at one speed; the command to its drive, the pitch current i_bt (-1 to 1),
/// is recorded instead. Models know revolutions: n_bt = (revolutions at i_bt = 1) * i_bt, where the ship's file states
/// them (`pitch_current` of the actuator n_bt).

/// Puts n_bt beside i_bt in recordings that have i_bt alone; where both are recorded, n_bt stays and counts. A missing
/// sample stays missing. Ships without the actuator n_bt do not ask for either.
/// Throws InputError for a recording with i_bt alone where the ship states no revolutions for it.
void add_revolutions(std::vector<Trajectory>& recordings, const Ship& ship);

/// Puts i_bt beside n_bt: add_revolutions() the other way. Throws InputError where the ship's file states no
/// `pitch_current`.
void add_pitch_current(Trajectory& trajectory, const Ship& ship);

/// Whether the ship knows the value of an actuator channel: it has the actuator, or states `pitch_current` for i_bt.
bool knows(const Ship& ship, Channel channel);
/// The value of such a channel where the ship's actuators stand as given.
double value_of(Channel channel, const Actuators<double>& actuators, const Ship& ship);

}  // namespace leeway
