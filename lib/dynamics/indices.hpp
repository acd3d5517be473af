#pragma once

#include <string>
#include <vector>

#include "dynamics/imo_criteria.hpp"
#include "dynamics/track.hpp"
#include "io/json.hpp"

namespace leeway {

/// What a recorded maneuver is counted from: the order, and the heading and the course over ground before it [rad].
struct Approach {
  double t_s = 0.0, heading = 0.0, course = 0.0;
};

/// What a naval architect reads off a maneuver, as JSON: names with units, lengths also in ship lengths, null for what
/// the run did not reach. Definitions: docs/maneuvers.md. Distances and headings are counted from the start of the run,
/// where the rudder order is given, or from the execute that the phases tell; the side of the rudder counts as
/// positive.
///   L_pp  [m]; NaN: not known, then nothing is given in ship lengths;  rudder, heading  as ordered [rad]
io::Json turning_indices(const Track& track, double rudder, double L_pp);
io::Json turning_indices(const Track& track, const Approach& approach, double rudder, double L_pp);
io::Json zigzag_indices(const Track& track, double rudder, double heading, double L_pp);
io::Json zigzag_indices(const Track& track, const Approach& approach, double rudder, double heading, double L_pp);
io::Json pull_out_indices(const Track& track, const std::vector<Phase>& phases, double L_pp);
io::Json spiral_indices(const Track& track, const std::vector<Phase>& phases, double L_pp);
io::Json crash_stop_indices(const Track& track, const std::vector<Phase>& phases, double L_pp);
io::Json coast_down_indices(const Track& track, double L_pp);
io::Json thruster_pulse_indices(const Track& track, const std::vector<Phase>& phases);
io::Json straight_indices(const Track& track, const Trajectory& trajectory, double L_pp);
/// The berth is the origin, with the heading of the quay [rad].
io::Json berthing_indices(const Track& track, double quay_heading, double L_pp);

/// Duration, length of the track, and the extremes of all states and actuators: what every run has.
io::Json run_indices(const Track& track, const Trajectory& trajectory, double L_pp);

/// All of the above: {"indices": ..., "imo_msc_137_76": ..., "run": ...}. `indices` is absent for maneuvers that have
/// no more than `run`, such as random orders.
///   trajectory  noise-free, every time step, all states known
io::Json maneuver_indices(const Trajectory& trajectory, const Ship& ship, const ManeuverFacts& facts);

/// The names of what is null, for a hint to the user: "advance_m", "speeds/3/time_s".
std::vector<std::string> not_reached(const io::Json& indices);

}  // namespace leeway
