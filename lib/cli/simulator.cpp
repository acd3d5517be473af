#include "cli/simulator.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "core/errors.hpp"
#include "dynamics/observation_noise.hpp"
#include "dynamics/replay.hpp"
#include "io/dataset_json.hpp"
#include "io/files.hpp"
#include "io/trajectory_csv.hpp"

namespace leeway::cli {
namespace {

void run_replay(const CLI::App& app, const SimOptions& opt) {
  TimeGrid grid = opt.grid;
  grid.duration_s = grid.sample_s;
  grid.check();
  if (opt.prediction != (opt.restart_steps > 0)) throw UsageError("--prediction and --restart-steps belong together");
  if (opt.prediction && !(opt.noise.empty() && opt.truth.empty() && opt.indices.empty()))
    throw UsageError("--noise, --truth and --indices do not apply to --prediction");
  std::vector<std::string> paths;
  for (const io::RecordingFile& file : io::expand_recordings(opt.recordings)) paths.push_back(file.path);
  if (!opt.prediction && paths.size() != 1)
    throw UsageError("one recording at a time, except with --restart-steps and --prediction");
  if (!opt.prediction) check_streams(opt);

  const Ship ship = read_ship_with_effects(opt);
  const std::vector<Trajectory> recordings = read_recordings(paths, opt.columns, opt.common.jobs);
  std::vector<RecordedInputs> inputs;
  for (const Trajectory& recording : recordings) {
    inputs.emplace_back(recording, ship, opt.hold ? InputInterpolation::hold : InputInterpolation::linear);
    warn_all(inputs.back().notices());
  }
  if (!opt.prediction) {
    if (!opt.indices.empty()) {
      const Trajectory every_step = replay(ship, recordings[0], inputs[0], {grid.dt_s, grid.dt_s, grid.dt_s});
      write_indices(app, opt, ship, every_step, {"replay", 0.0, 0.0, {}, 0.0}, {{"dt_s", grid.dt_s}});
    }
    return write_result(opt, replay(ship, recordings[0], inputs[0], grid));
  }

  const auto predict = [&](std::size_t i, io::PredictionWriter& writer) {
    if (replay_sequences(ship, recordings[i], inputs[i], grid, opt.restart_steps, writer) == 0)
      spdlog::warn("{}: shorter than {} points without a gap; it gives no sequence", recordings[i].file,
                   opt.restart_steps);
  };
  if (opt.output == "-") {
    io::PredictionWriter writer("-");
    for (std::size_t i = 0; i < recordings.size(); ++i) predict(i, writer);
    return writer.commit();
  }
  io::make_directories(opt.output);
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    io::PredictionWriter writer(fmt::format("{}/{}.csv", opt.output, recordings[i].name));
    predict(i, writer);
    writer.commit();
  }
}

}  // namespace

void add_output(CLI::App& sub, SimOptions& opt, const std::string& what) {
  sub.add_option("-o,--output", opt.output, what)->capture_default_str();
}

void add_ship_and_steps(CLI::App& sub, SimOptions& opt) {
  sub.add_option("--ship", opt.ship, "ship (JSON), or the name of a shipped one: 'mmg-sim ships' lists them")
      ->required();
  sub.add_option("--effect", opt.effects,
                 "physics to add to the ship's effects (JSON, see 'mmg-sim effects'); may be given several times")
      ->type_name("TEXT")
      ->expected(1)
      ->take_all();
  sub.add_option("--dt-s", opt.grid.dt_s, "time step of the integration [s]")
      ->check(cli::positive())
      ->capture_default_str();
  sub.add_option("--sample-s", opt.grid.sample_s, "time between rows, a multiple of the time step [s]")
      ->check(cli::positive())
      ->capture_default_str();
}

void add_noise(CLI::App& sub, SimOptions& opt) {
  sub.add_option(
      "--noise", opt.noise,
      "observation noise (JSON), or the name of a shipped one: paper-model-scale, paper-full-scale [default: none]");
  sub.add_option("--truth", opt.truth, "also write the noise-free states here (CSV)");
}

void add_indices(CLI::App& sub, SimOptions& opt) {
  sub.add_option("--indices", opt.indices,
                 "write what is read off the maneuver, from the noise-free states of every time step, here (JSON)");
}

void write_indices(const CLI::App& app, const SimOptions& opt, const Ship& ship, const Trajectory& every_step,
                   const ManeuverFacts& facts, io::Json conditions) {
  io::Json json{{"maneuver", facts.maneuver},
                {"ship", {{"name", ship.name}, {"L_pp_m", ship.particulars.L_pp}, {"scale", ship.scale}}},
                {"conditions", std::move(conditions)}};
  json.update(maneuver_indices(every_step, ship, facts));
  std::vector<std::string> inputs{ship.file};
  if (!opt.schedule.empty()) inputs.push_back(opt.schedule);
  inputs.insert(inputs.end(), opt.effects.begin(), opt.effects.end());
  inputs.insert(inputs.end(), opt.recordings.begin(), opt.recordings.end());
  json["provenance"] = provenance(app, opt.common, inputs, {"--truth", "--indices", "--noise"});
  io::write_text(opt.indices, io::to_text(json));
  if (!json.contains("indices")) return;
  if (const std::vector<std::string> missing = not_reached(json["indices"]); !missing.empty())
    spdlog::warn("null in the indices, since this run of {} s did not reach or did not tell it: {}",
                 every_step[Channel::t].back() - every_step[Channel::t].front(), fmt::join(missing, ", "));
}

void check_streams(const SimOptions& opt) {
  if ((opt.output == "-") + (opt.truth == "-") + (opt.indices == "-") > 1)
    throw UsageError("only one of --output, --truth and --indices can be the standard output");
}

void write_result(const SimOptions& opt, const Trajectory& truth) {
  const ObservationNoise noise = opt.noise.empty() ? ObservationNoise{} : read_noise(opt.noise);
  if (!opt.truth.empty()) io::write_trajectory(opt.truth, truth);
  io::write_trajectory(opt.output, observed(truth, noise, {opt.common.seed, "observation noise"}));
}

Ship read_ship_with_effects(const SimOptions& opt) {
  Ship ship = read_ship(opt.ship);
  for (const std::string& file : opt.effects)
    for (EffectEntry& effect : read_effects(file)) ship.effects.push_back(std::move(effect));
  return ship;
}

Command add_replay_command(CLI::App& app, SimOptions& opt) {
  CLI::App* replay_run = app.add_subcommand("replay", "drive the ship with a recording's actuators and wind");
  add_ship_and_steps(*replay_run, opt);
  replay_run
      ->add_option("recordings", opt.recordings, "recordings (CSV), dataset.json or dataset.json#SET; '-' for stdin")
      ->required();
  replay_run->add_option("--columns", opt.columns,
                         "columns map (JSON) of foreign recordings, or its name: frt-ds-esso");
  replay_run->add_flag("--hold", opt.hold, "hold inputs between samples [default: linear]");
  replay_run
      ->add_option("--restart-steps", opt.restart_steps, "restart from the recorded state every so many points [1]")
      ->check(cli::in_range(2.0, 1e9));
  replay_run->add_flag("--prediction", opt.prediction, "write prediction CSV, one file per recording");
  add_noise(*replay_run, opt);
  add_indices(*replay_run, opt);
  add_output(*replay_run, opt, "trajectory (CSV), with --prediction a folder; '-' for stdout");
  return {replay_run, [&app, &opt] { run_replay(app, opt); }};
}

}  // namespace leeway::cli
