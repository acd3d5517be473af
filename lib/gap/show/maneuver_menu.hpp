#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dynamics/phased_maneuvers.hpp"
#include "gap/policy/options.hpp"

namespace leeway::gap {

/// One run of a maneuver, from a ship that is turned to a heading.
struct ManeuverRun {
  double heading_rad = 0.0;
  std::function<std::unique_ptr<Maneuver>(const SimulatedShip&)> make;
};

/// A maneuver that could be recorded next.
struct MenuItem {
  std::string name;     ///< "turning circles, 35 deg to both sides"
  std::string command;  ///< of mmg-sim, without the ship
  double u_mps = 0.0;   ///< speed and revolutions at the start
  double n_rps = 0.0;
  double each_s = 0.0;  ///< duration of a run
  std::vector<ManeuverRun> runs;
};

/// The standard maneuvers at the usual speed and some at a lower one, one astern, and those of the thrusters that the
/// ship has; their durations scale with the ship.
///   time_scale  sqrt(L/g) by that of a 3 m ship
///   limits      rudder angles are kept within these; areas and times are cut where the runs are known
std::vector<MenuItem> maneuver_menu(const Ship& ship, double time_scale, const NextLimits& limits);

}  // namespace leeway::gap
