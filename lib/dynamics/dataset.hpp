#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dynamics/maneuvers.hpp"
#include "dynamics/observation_noise.hpp"
#include "dynamics/recorded_columns.hpp"

namespace leeway {

/// A quantity that is drawn for each run, uniform within [low, high]; low = high: fixed.
struct DrawnRange {
  double low = 0.0, high = 0.0;
};

enum class ManeuverKind {
  random,
  berthing,
  port_navigation,
  replay,
  zigzag,
  turning,
  pull_out,
  spiral,
  crash_stop,
  coast_down,
  thruster_pulses,
  straight,
};

struct DatasetSpec;

/// One run of a dataset.
struct RunSpec {
  std::string name;  ///< of the recording, unique in the dataset
  ManeuverKind kind = ManeuverKind::random;
  double rudder = 0.0, heading = 0.0;  ///< [rad], of maneuvers that have them
  double u0_mps = 0.0;
  double duration_s = 0.0;              ///< the mean, where it is shared
  DrawnRange wind_speed_mps, wind_dir;  ///< [m/s], [rad]; means where the wind is stochastic
  bool has_stochastic_wind = false;
  std::vector<EffectEntry> unrecorded;  ///< physics of this run that no column holds
  /// Of a replay: the data set whose run it replays at its own ship's size, and that run's place among all of them.
  std::shared_ptr<const DatasetSpec> replayed;
  std::size_t replayed_place = 0;
};

/// Neighboring runs of a set that share a total duration.
struct SharedDuration {
  std::size_t first = 0, count = 0;
  double total_s = 0.0;
  double replayed_at_scale = 1.0;  ///< as long as whole samples are that a ship smaller by this takes to replay them
};

struct DatasetSpec {
  struct Set {
    std::string name;
    std::vector<RunSpec> runs;
    std::vector<SharedDuration> shared_durations;
  };
  Ship ship;
  TimeGrid grid;  ///< its duration is not used
  ObservationNoise noise;
  RecordedColumns recorded;
  std::vector<Set> sets;
  std::vector<std::string> input_files;  ///< what was read, for the provenance
};

/// Reads a dataset specification (docs/mmg-sim.md): a path, or the name of a shipped one such as "demo".
/// Throws InputError for anything unknown, missing or impossible.
DatasetSpec read_dataset_spec(const std::string& name_or_path);

/// Whole samples for each of `count` runs: within 30 % of the mean, rounded, and exactly `total` in sum; at least one
/// each if there are at least two for each.
std::vector<std::size_t> share_samples(std::size_t total, std::size_t count, RandomStream stream);

/// Simulates all runs and writes <folder>/<set>/<name>.csv, <folder>/<set>/truth/<name>.csv, where there is more to say
/// of a set's runs (plan of a pilot, unrecorded physics, winds of a replay) <folder>/<set>/truth/runs.json and, last,
/// <folder>/dataset.json. Each run has its own random streams by its place in the specification: the bytes do not
/// depend on `jobs`. Throws IoError, NumericalError with the run's name.
///   progress  told the share of the runs that is done, by any thread
void generate_dataset(const DatasetSpec& spec, const std::string& folder, std::uint64_t seed, std::size_t jobs,
                      const io::Json& provenance, const std::function<void(double)>& progress = nullptr);

}  // namespace leeway
