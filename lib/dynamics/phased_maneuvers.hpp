#pragma once

#include <optional>

#include "dynamics/maneuvers.hpp"

namespace leeway {

/// Maneuvers made of phases, each with orders that stand until something has come or its time is over. They end by
/// themselves. All start from the given ship's state and actuators; what a phase does not order stays as it is there.
///
/// A turn counts as steady when the yaw rate has stayed within 0.001 u0/L_pp for 5 L_pp/u0 (our choice), u0 being the
/// speed at the start. Where a time is left out it is a number of L_pp/u0, so that it suits models and ships alike.
/// All throw UsageError where they need a speed ahead at the start and there is none.

/// Rudder to starboard, amidships, to port, amidships, each until the turn is steady: the yaw rates that remain
/// amidships tell whether the ship is straight-line stable. Phases carry the rudder angle.
///   amidships_rad  what counts as amidships: the neutral rudder angle of a ship that is not symmetric
///   hold_s         longest time of a phase; default 60 L_pp/u0
std::unique_ptr<Maneuver> pull_out(const SimulatedShip& start, double rudder_rad, double amidships_rad = 0.0,
                                   std::optional<double> hold_s = {});

/// Dieudonne's spiral: rudder from +rudder_rad stepwise to -rudder_rad and back, each until the turn is steady. Phases
/// carry the rudder angle.
///   step_rad       > 0; rudder_rad is a multiple of it
///   fine_step_rad  > 0, between -step_rad and step_rad, where the loop of an unstable ship is; step_rad is a multiple
///   hold_s         longest time of a phase; default 60 L_pp/u0
std::unique_ptr<Maneuver> spiral(const SimulatedShip& start, double rudder_rad, double step_rad, double fine_step_rad,
                                 std::optional<double> hold_s = {});

/// A straight approach under a heading controller, then full astern until u = 0: the propeller to `astern_rps`, the
/// rudders amidships. A ship whose propeller does not reverse and that has twin rudders puts them to the clamshell
/// (port rudder to its lower, starboard rudder to its upper limit) at constant revolutions. Two phases, with the
/// revolutions.
///   approach_s  default 5 L_pp/u0
///   astern_rps  default: the revolutions of the start, reversed, or the propeller's limit
/// Throws UsageError for a ship that has neither way to stop, and for `astern_rps` that are not below 0 or out of
/// limits.
std::unique_ptr<Maneuver> crash_stop(const SimulatedShip& start, std::optional<double> approach_s = {},
                                     std::optional<double> astern_rps = {});

/// Propeller stopped, rudders amidships, until the speed is a tenth of that at the start or 300 L_pp/u0 are over.
std::unique_ptr<Maneuver> coast_down(const SimulatedShip& start);

struct ThrusterPulses {
  Channel thruster = Channel::n_bt;  ///< n_bt or n_st
  double rps = 0.0;                  ///< revolutions of a pulse, > 0
  double pulse_s = 0.0, rest_s = 0.0;
  std::size_t pulses = 2;
};

/// The pulses that suit a ship: its bow thruster (or else the stern thruster) at the largest revolutions that both
/// sides have, 40 sqrt(L_pp/g) long with 120 sqrt(L_pp/g) between, in which most of the yaw decays. Throws UsageError
/// for a ship without thrusters.
ThrusterPulses thruster_pulses_for(const Ship& ship, std::optional<Channel> thruster = {});

/// Pulses of a thruster to starboard, to port, and so on, each followed by a rest. Phases: pulse, rest, pulse, ...
/// Throws UsageError for revolutions beyond the thruster's limits.
std::unique_ptr<Maneuver> thruster_pulses(const SimulatedShip& start, const ThrusterPulses& pulses);

}  // namespace leeway
