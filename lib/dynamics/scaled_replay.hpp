#pragma once

#include "dynamics/replay.hpp"
#include "dynamics/wind_process.hpp"
#include "recording/froude_law.hpp"

namespace leeway {

/// Drives a ship with the inputs that a ship of the same shape and another size recorded: actual values, scaled in time
/// by Froude's law, linear between the samples, from its scaled first state, with nobody at the helm.
///   recording  of the other ship
///   wind       on this ship
///   grid       with the duration; the recording reaches that far
Trajectory replay_to_scale(const Ship& ship, const Trajectory& recording, const FroudeLaw& law, WindProcess wind,
                           const TimeGrid& grid);

/// Which replays count as the run of a ship that keeps some headway.
struct ReplayRule {
  double most_astern = 0.01;  ///< share of the samples with u < 0
  double most_beyond = 1.3;   ///< speed and yaw rate, by the largest ones of the run that is replayed
};

/// Whether a replay follows the run that it replays closely enough.
///   scaled  that run in this ship's lengths and times: scaled_down()
bool is_like(const Trajectory& replay, const Trajectory& scaled, const ReplayRule& rule = {});

}  // namespace leeway
