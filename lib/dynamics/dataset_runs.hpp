#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "dynamics/dataset.hpp"

/// The runs of a data set: their kinds, what they start from, how long they take, their simulation.
namespace leeway {

struct ManeuverKindInfo {
  ManeuverKind kind;
  std::string_view word, in_names;
  bool has_rudder;  ///< one run for each of the given angles
};
inline constexpr std::array<ManeuverKindInfo, 12> kManeuverKinds{{
    {ManeuverKind::random, "random", "r", false},
    {ManeuverKind::berthing, "berthing", "b", false},
    {ManeuverKind::port_navigation, "port-navigation", "b", false},
    {ManeuverKind::replay, "replay", "b", false},
    {ManeuverKind::zigzag, "zigzag", "z", true},
    {ManeuverKind::turning, "turning", "t", true},
    {ManeuverKind::pull_out, "pull-out", "pull-out-", true},
    {ManeuverKind::spiral, "spiral", "spiral-", true},
    {ManeuverKind::crash_stop, "crash-stop", "crash-stop", false},
    {ManeuverKind::coast_down, "coast-down", "coast-down", false},
    {ManeuverKind::thruster_pulses, "thruster-pulses", "thruster-pulses", false},
    {ManeuverKind::straight, "straight", "straight", false},
}};

/// A run with the duration that it has with a seed, and the place of its set.
struct PlacedRun {
  std::size_t set = 0;
  RunSpec run;
};

/// All runs of a data set in their order, which is that of their random streams.
std::vector<PlacedRun> placed_runs(const DatasetSpec& spec, std::uint64_t seed);

/// A noise-free run, and what the recording does not say of it (null where that is nothing).
struct SimulatedRun {
  Trajectory truth;
  io::Json notes;
};

/// Whether a run has notes.
bool has_notes(const RunSpec& run);

/// The run with the given place in the data set. Throws NumericalError with the run's name.
SimulatedRun simulate_run(const DatasetSpec& spec, const RunSpec& run, std::uint64_t seed, std::size_t place);

/// Throws what simulate_run() would at the start: UsageError for a ship that cannot make the maneuver, NumericalError
/// for a speed that it cannot hold, InputError for an effect that is wrong.
void require_possible(const Ship& ship, const RunSpec& run);

/// Notes of many runs summed up: how many winds the replays among them took.
io::Json summary_of(const std::vector<io::Json>& notes);

}  // namespace leeway
