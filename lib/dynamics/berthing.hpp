#pragma once

#include <array>
#include <string_view>

#include "dynamics/pilot.hpp"
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

/// One berthing: the midship of the moored ship is the origin of the earth axes.
struct BerthingPlan {
  BerthingPattern pattern = BerthingPattern::straight;
  bool is_starboard_side = false;  ///< the side of the ship at the quay
  double quay_heading = 0.0;       ///< of the moored ship [rad]
  PilotPlan steering;
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

/// A pilot who follows the plan for 450 sqrt(L_pp/g).
///   stream  his misjudgments and the times of his looks
std::unique_ptr<Maneuver> berthing(const Ship& ship, const BerthingPlan& plan, RandomStream stream);

}  // namespace leeway
