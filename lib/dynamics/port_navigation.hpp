#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "dynamics/pilot.hpp"
#include "io/json.hpp"

namespace leeway {

/// How a port navigation ends.
enum class PortEnd {
  hover,  ///< stops close off the berth and is held there
  crab,   ///< stops off the berth and goes sideways to it
  turn,   ///< stops off the berth, turns on the spot and goes sideways to it
};
inline constexpr std::array<std::string_view, 3> kPortEnds{"hover", "crab", "turn"};

/// From entering a port to the berth, whose midship is the origin of the earth axes.
struct PortPlan {
  std::string_view port;
  PortEnd end = PortEnd::crab;
  bool is_starboard_side = false;      ///< the side of the ship at the quay
  double quay_heading = 0.0;           ///< of the moored ship [rad]
  std::vector<double> course_changes;  ///< of the route, in their order [rad]
  PilotPlan steering;
};

/// How long a port navigation takes where nothing else is asked for: 320 sqrt(L_pp/g).
double usual_port_navigation_s(const Ship& ship);

/// Draws one of three ports, one of its two berths, the route with one to three course changes, and a pilot. The
/// ports, the scatter about their routes and the pilots are our choice, made for a ship of 3 m and scaled by Froude's
/// law. The route is so long that the ship is at the berth, or about to be, after `duration_s`. Throws UsageError for
/// a ship without VecTwin rudders or bow thruster.
PortPlan draw_port_navigation(const Ship& ship, double duration_s, RandomStream stream);

/// Port, end, side of the quay, its heading, course changes and the start, with units in the keys.
io::Json to_json(const PortPlan& plan);

/// A pilot who follows the plan: at harbor speed with both rudders together, which he opens to slow down; then, off the
/// berth, with each rudder on its own and the thruster, keeping some headway.
///   stream  his misjudgments and the times of his looks
std::unique_ptr<Maneuver> port_navigation(const Ship& ship, const PortPlan& plan, double duration_s,
                                          RandomStream stream);

}  // namespace leeway
