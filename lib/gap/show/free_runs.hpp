#pragma once

#include "gap/detect/blocks.hpp"
#include "gap/result/explanation.hpp"

/// How well a simulator runs free from recorded states.
namespace leeway::gap {

/// Consecutive points of a stretch.
struct Run {
  std::size_t stretch = 0, begin = 0, end = 0;  ///< end: one past the last
};
/// Every stretch from its first point to its last.
std::vector<Run> whole_runs(const Campaign& campaign);
/// What the blocks of a fold cover, neighbors joined.
std::vector<Run> runs_of(const Campaign& campaign, const Blocks& blocks, const std::vector<std::size_t>& fold);

/// A simulator and the runs that judge it.
struct ShipOnRuns {
  Ship ship;
  std::vector<Run> runs;
};

/// Free runs of 30, 100 and 300 s, one after another along each run, from the smoothed states at their beginnings with
/// the recorded inputs, against what was measured. A run shorter than that is run in one. Position errors start at 0.
Scores free_runs(const Campaign& campaign, const std::vector<Smoothed>& starts, const std::vector<ShipOnRuns>& ships,
                 std::size_t jobs);

/// Mean logarithm of the errors of free runs in their units, over channels and lengths.
double log_error(const Scores& scores);

/// Whether the mean logarithm of the errors falls by more than its standard error from one part that was left out to
/// the other.
///   before, after  the same parts in the same order
bool is_beyond_chance(const Campaign& campaign, const std::vector<Smoothed>& starts,
                      const std::vector<ShipOnRuns>& before, const std::vector<ShipOnRuns>& after, std::size_t jobs);

/// Positions and velocities along free runs of kShownHorizon_s, by recording; a row of NaN stands between two runs.
std::vector<FreeTrack> free_tracks(const Campaign& campaign, const std::vector<Smoothed>& starts,
                                   const std::vector<ShipOnRuns>& ships);

/// Share of white innovations within their intervals of 50, 90, 95 and 99 %, by the per cent.
std::map<int, double> coverage(const std::vector<Smoothed>& smoothed, const std::vector<Run>& runs);

}  // namespace leeway::gap
