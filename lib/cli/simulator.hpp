#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cli/options.hpp"
#include "dynamics/indices.hpp"
#include "dynamics/recorded_columns.hpp"
#include "dynamics/simulation.hpp"

/// The subcommands of mmg-sim that simulate.
namespace leeway::cli {

/// What the subcommands ask for; each uses those that it adds.
struct SimOptions {
  CommonOptions common;
  std::string ship, output = "-", noise, truth, indices, columns, schedule, thruster;
  std::vector<std::string> recordings, effects;
  TimeGrid grid;
  RecordedColumns recorded;
  std::optional<double> duration_s, u0_mps, n_p_rps, hold_s, approach_s, astern_rps, thruster_rps, pulse_s, rest_s, kp,
      kd;
  double zigzag_rudder_deg = 10.0, turning_rudder_deg = 35.0, pull_out_rudder_deg = 20.0, spiral_rudder_deg = 25.0,
         amidships_deg = 0.0, step_deg = 5.0, fine_step_deg = 0.5, heading_deg = 0.0, wind_speed_mps = 0.0,
         wind_dir_deg = 0.0;
  std::size_t pulses = 2;
  std::string wind = "steady";
  std::size_t restart_steps = 0;
  bool hold = false, prediction = false;
};

/// A subcommand and what it does once the command line is read.
struct Command {
  CLI::App* subcommand;
  std::function<void()> run;
};

/// turning, zigzag, ...: one for each maneuver. `app` and `opt` must outlive the commands.
std::vector<Command> add_maneuver_commands(CLI::App& app, SimOptions& opt);
Command add_replay_command(CLI::App& app, SimOptions& opt);

/// draws: ships drawn from what a ship's file states of its coefficients.
struct DrawOptions {
  std::size_t count = 0;
  double spread = 1.0;
};
Command add_draws_command(CLI::App& app, SimOptions& opt, DrawOptions& draws);

/// estimate: a ship from particulars; scale: a ship of another size.
struct EstimateOptions {
  std::string particulars;
  std::vector<std::string> without;
  bool compares = false;
};
Command add_estimate_command(CLI::App& app, SimOptions& opt, EstimateOptions& estimate);
Command add_scale_command(CLI::App& app, SimOptions& opt, double& length_m);

/// import, columns, indices: foreign recordings in leeway's form, a map for them, what is read off them.
struct RecordingIndexOptions {
  std::optional<double> length_m;
  bool json = false;
};
Command add_import_command(CLI::App& app, SimOptions& opt);
Command add_columns_command(CLI::App& app, SimOptions& opt);
Command add_indices_command(CLI::App& app, SimOptions& opt, RecordingIndexOptions& indices);

/// --output.
void add_output(CLI::App& sub, SimOptions& opt, const std::string& what);

// Shared by maneuvers and replay.

/// --ship, --effect, --dt-s, --sample-s.
void add_ship_and_steps(CLI::App& sub, SimOptions& opt);
/// --noise, --truth, --record-bow-thruster, --record-wind.
void add_noise(CLI::App& sub, SimOptions& opt);
/// --indices.
void add_indices(CLI::App& sub, SimOptions& opt);
/// Throws UsageError if two results are to go to one place, or one to where an input lies.
void check_outputs(const SimOptions& opt);
/// Removes the main output of an earlier run where further ones are written: it comes last, and where it lies they are
/// of its run.
void begin_outputs(const SimOptions& opt);
/// The ship, with the effects of --effect, by which it has another name.
Ship read_ship_with_effects(const SimOptions& opt);
/// The provenance of a simulation, which names the ship.
///   recordings  those that were replayed
io::Json simulation_provenance(const CLI::App& app, const SimOptions& opt, const Ship& ship,
                               const std::vector<std::string>& recordings,
                               const std::vector<std::string>& also_leave_out);
/// The recording of a run, and its truth where that is asked for; beside files their provenance.
///   recordings  as above
void write_result(const CLI::App& app, const SimOptions& opt, const Ship& ship, Trajectory truth,
                  const std::vector<std::string>& recordings = {});
void write_indices(const CLI::App& app, const SimOptions& opt, const Ship& ship, const Trajectory& every_step,
                   const ManeuverFacts& facts, io::Json conditions);

}  // namespace leeway::cli
