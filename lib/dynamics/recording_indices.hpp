#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/recorded_maneuver.hpp"
#include "io/json.hpp"

namespace leeway {

/// The ship that made a recording, as far as its indices and IMO's criteria depend on it.
struct RecordedShip {
  std::optional<double> L_pp_m;          ///< of the ship as recorded
  double scale = 1.0;                    ///< length of the full-scale ship by the recorded one's
  std::optional<double> hardest_rudder;  ///< [rad]
};
RecordedShip recorded_ship(const Ship& ship);

/// The samples in which all states are known; what a recording lacks altogether is integrated: a position from the
/// velocities, a heading from the yaw rate. `notices` says what was done. Throws InputError where fewer than two
/// samples are left.
Trajectory complete_states(const Trajectory& recording, std::vector<std::string>& notices);

/// {"recording", "maneuver", "order_s", "rudder_deg", ..., "indices", "imo_msc_137_76", "run"}: what is read off a
/// recording by the same functions as off a simulation (dynamics/indices.hpp). "maneuver" is null where neither a
/// turning circle nor a zigzag is recognized; then there is "run" alone.
io::Json recording_indices(const Trajectory& recording, const RecordedShip& ship, std::vector<std::string>& notices);

/// The same as lines to read.
std::string recording_indices_text(const io::Json& indices);

}  // namespace leeway
