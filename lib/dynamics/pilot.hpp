#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "dynamics/maneuvers.hpp"
#include "recording/froude_law.hpp"

/// A pilot who steers a VecTwin ship along a plan: berthing.hpp and port_navigation.hpp draw plans.
namespace leeway {

/// A part of a plan. Earth axes.
struct PilotLeg {
  enum class Kind {
    fairway,      ///< along the line that the pose lies on, both rudders together; opened, they slow the ship down
    under_way,    ///< along that line, in the direction of its heading, each rudder on its own
    on_the_spot,  ///< to the pose with thruster and rudders, at hardly any surge
  };
  Kind kind = Kind::under_way;
  Vec3<double> pose = Vec3<double>::Zero();
  double speed_mps = 0.0;      ///< along the line, or sideways
  double way_to_stop_m = 0.0;  ///< from the pose on, in which the ship is to stop; infinite where it is not to
  double leave_m = 0.0;        ///< how far before the pose the line is left, to turn into the next one
};

/// What sets one pilot apart from the other.
struct PilotTraits {
  double reaction_s = 0.0;                              ///< from the look at the ship to the order
  double interval_s = 0.0;                              ///< mean time between looks; each time is within +-30 %
  double deceleration_mps2 = 0.0;                       ///< at which the approach is planned to be slowed down
  double heading_s = 0.0;                               ///< time in which a heading error is to vanish
  double settle_s = 0.0;                                ///< time in which a velocity is to be reached
  double settle_together_s = 0.0;                       ///< the same of the yaw rate in a fairway
  double turn_under_way = 0.0, turn_on_the_spot = 0.0;  ///< most yaw rate that he wants [rad/s]
  double lookahead_m = 0.0;                             ///< distance over which the ship returns to a line
  double rudder_step_rad = 0.0;                         ///< orders are multiples of it
  double thruster_step_rps = 0.0;
  double misjudgment = 0.0;                           ///< standard deviation of the factor on an intended acceleration
  double headway_mps = 0.0, least_headway_mps = 0.0;  ///< kept at a pose; and where there is no room left to do so
  double together_rad = 0.0;                          ///< in a fairway: most rudder
  double heading_band = 0.0, speed_band_mps = 0.0;    ///< in a fairway: errors that he leaves alone [rad]
};

struct PilotPlan {
  Vec3<double> start = Vec3<double>::Zero();
  double u0_mps = 0.0;
  std::vector<PilotLeg> legs;  ///< at least one; the last one is kept up
  PilotTraits pilot;
};

/// Plans are made for a ship of 3 m: another ship by that one.
FroudeLaw froude_law(const Ship& ship);

/// A point `ahead` of a pose along its heading and `to_starboard` of it; a pose with another heading.
Vec3<double> moved(const Vec3<double>& pose, double ahead, double to_starboard);
Vec3<double> turned(const Vec3<double>& pose, double angle);

/// The ship at the start of a plan, its rudders opened to the angle that holds the speed.
SimulatedShip ship_at_start(const Ship& ship, const PilotPlan& plan);

/// A pilot who follows the plan. Every few seconds he looks at pose and velocity, and, after a reaction time, orders
/// the rounded rudder angles and thruster revolutions whose accelerations by the ship's model in calm air come closest
/// to those he wants; what wind or current does he learns from the difference between expected and actual velocity.
/// The propeller is left alone: rudders alone set the speed. Throws UsageError, which begins with the maneuver's name,
/// for a ship without VecTwin rudders or bow thruster.
///   stream     his misjudgments and the times of his looks
///   longest_s  how long the maneuver takes
std::unique_ptr<Maneuver> piloted(const Ship& ship, PilotPlan plan, RandomStream stream, std::string_view maneuver,
                                  double longest_s);

}  // namespace leeway
