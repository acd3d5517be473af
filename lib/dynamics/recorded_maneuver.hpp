#pragma once

#include <string>
#include <vector>

#include "dynamics/indices.hpp"
#include "recording/trajectory.hpp"

namespace leeway {

/// What a recording shows of a maneuver, from the rudder and the heading alone.
struct RecordedManeuver {
  std::string name;     ///< "turning", "zigzag"; empty: neither
  Approach approach;    ///< the order, and heading and course before it
  double end_s = 0.0;   ///< where the rudder leaves its last angle
  double rudder = 0.0;  ///< as ordered, negative to port [rad]: whole degrees, where the rudder was within 0.35
  double measured_rudder = 0.0;  ///< median over the times at which it was held [rad]
  double heading = 0.0;          ///< zigzag: change of heading at which the rudder was put over [rad]
};

/// Recognizes a turning circle or a zigzag.
///
/// Rudder: the mean of those that are recorded. It is held while it stays within 0.5 deg (or 4 %); one held angle is a
/// turn, held angles that alternate between the sides are a zigzag. The order is given where the rudder begins to move
/// to the first of them; at the start of a recording that begins less than a quarter of the time to 10 deg of heading
/// before that, since a recording of a maneuver begins with its order, and steering gears are late.
/// A zigzag's heading is the roundest angle that lies between the headings before and after the rudder was put over;
/// it is counted from the middle of those on both sides, where this contradicts the heading at the order.
///   trajectory  all states and the rudder known in every sample
RecordedManeuver recognize_maneuver(const Trajectory& trajectory);

}  // namespace leeway
