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
  double measured_rudder = 0.0;                    ///< median over the times at which it was held [rad]
  double heading = 0.0;                            ///< zigzag: change of heading at which the rudder was put over [rad]
  double least_heading = 0.0, most_heading = 0.0;  ///< as measured before and after that [rad]
  double noise = 0.0, resolution = 0.0;            ///< of the recorded rudder [rad]
  double order_doubt_s = 0.0;  ///< by which the order may be earlier or later; 0 for a rudder recorded well
};

/// Recognizes a turning circle or a zigzag.
///
/// Rudder: the mean of those that are recorded. It is at one place while it stays within 0.5 deg (or 4 %), three
/// standard deviations of its noise, or what it is rounded to. The angle that is held while the ship turns most tells
/// how far it is put over. One time that it is put over so far is a turn; several that alternate between the sides are
/// a zigzag, also where the rudder turns back as soon as it is there, or before. The order is given where the rudder
/// was last at its place before; at the start of a recording that begins less than a quarter of the time to 10 deg of
/// heading before that, since a recording of a maneuver begins with its order, and steering gears are late. A zigzag's
/// heading is the roundest angle that lies between the headings before and after the rudder was put over; a multiple of
/// 5 deg, or 1 deg, where the rudder was late; it is counted from the middle of those on both sides, where this
/// contradicts the heading at the order.
///   trajectory  all states and the rudder known in every sample
RecordedManeuver recognize_maneuver(const Trajectory& trajectory);

}  // namespace leeway
