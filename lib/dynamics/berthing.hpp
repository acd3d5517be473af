#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "dynamics/maneuvers.hpp"
#include "io/json.hpp"

namespace leeway {

enum class BerthingPattern {
  straight,  ///< along the quay to a point off the berth, stop, crab to the berth
  curved,    ///< the same from a start on another heading
  turn,      ///< to a point off the berth on another heading, turn on the spot, crab to the berth
  shift,     ///< from rest at the quay: off it, along it, stop, crab to the berth
  leave,     ///< from rest at the berth: off it, turn away, go ahead
};
inline constexpr std::array<std::string_view, 5> kBerthingPatterns{"straight", "curved", "turn", "shift", "leave"};

/// A part of a berthing plan. Earth axes.
struct BerthingLeg {
  enum class Kind {
    under_way,    ///< along the line that the pose lies on, in the direction of its heading
    on_the_spot,  ///< to the pose with thruster and rudders, at hardly any surge
  };
  Kind kind = Kind::under_way;
  Vec3<double> pose = Vec3<double>::Zero();
  double speed_mps = 0.0;  ///< along the line, or sideways
  bool stops = true;       ///< whether the ship is to have stopped at the end of the line
};

/// What sets one pilot apart from the other.
struct PilotTraits {
  double reaction_s = 0.0;         ///< from the look at the ship to the order
  double interval_s = 0.0;         ///< mean time between looks; each time is within +-30 %
  double deceleration_mps2 = 0.0;  ///< at which the approach is planned to be slowed down
  double heading_s = 0.0;          ///< time in which a heading error is to vanish
  double lookahead_m = 0.0;        ///< distance over which the ship returns to a line
  double rudder_step_rad = 0.0;    ///< orders are multiples of it
  double thruster_step_rps = 0.0;
  double misjudgment = 0.0;  ///< standard deviation of the factor on an intended acceleration
};

/// One berthing: the midship of the moored ship is the origin of the earth axes.
struct BerthingPlan {
  BerthingPattern pattern = BerthingPattern::straight;
  bool is_starboard_side = false;  ///< the side of the ship at the quay
  double quay_heading = 0.0;       ///< of the moored ship [rad]
  Vec3<double> start = Vec3<double>::Zero();
  double u0_mps = 0.0;
  std::vector<BerthingLeg> legs;  ///< at least one; the last one is kept up
  PilotTraits pilot;
};

/// Draws a plan. All numbers are our choice, made for a 3 m model and scaled to the ship by Froude's law: lengths with
/// L_pp, times and speeds with its root. Throws UsageError for a ship without VecTwin rudders or bow thruster.
BerthingPlan draw_berthing(const Ship& ship, RandomStream stream);

/// Pattern, side of the quay, its heading and the start, with units in the keys.
io::Json to_json(const BerthingPlan& plan);

/// Mean speed [m/s], up to 1 m/s at 3 m in Froude's scale, and direction [rad] of the wind of a berthing: our choice.
struct MeanWind {
  double speed_mps = 0.0, direction = 0.0;
};
MeanWind draw_mean_wind(const Ship& ship, RandomStream stream);

/// The ship at the start of a plan, its rudders opened to the angle that holds the speed.
SimulatedShip berthing_start(const Ship& ship, const BerthingPlan& plan);

/// A pilot who follows the plan. Every few seconds he looks at pose and velocity, and, after a reaction time, orders
/// the rounded rudder angles and thruster revolutions whose accelerations by the ship's model in calm air come closest
/// to those he wants; what wind or current does he learns from the difference between expected and actual velocity.
/// The propeller is left alone: rudders alone set the speed. It takes 450 sqrt(L_pp/g).
///   stream  his misjudgments and the times of his looks
std::unique_ptr<Maneuver> berthing(const Ship& ship, BerthingPlan plan, RandomStream stream);

}  // namespace leeway
