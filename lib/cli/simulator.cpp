#include "cli/simulator.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "cli/inputs.hpp"
#include "core/errors.hpp"
#include "core/similar_words.hpp"
#include "dynamics/coefficient_law.hpp"
#include "dynamics/observation_noise.hpp"
#include "dynamics/replay.hpp"
#include "dynamics/run_notices.hpp"
#include "effects/catalogue.hpp"
#include "io/dataset_json.hpp"
#include "io/described_file.hpp"
#include "io/files.hpp"
#include "io/result_folder.hpp"
#include "io/trajectory_csv.hpp"
#include "recording/samples.hpp"
#include "ship/pitch_current.hpp"

namespace leeway::cli {
namespace {

Inputs inputs_of(const SimOptions& opt) {
  Inputs inputs;
  inputs.config("ships", opt.ship).config("noise", opt.noise).config("columns", opt.columns).files(opt.effects);
  return inputs.files({opt.schedule}).recordings(opt.recordings);
}

// What provenance says of the ship that ran.
io::Json named(const Ship& ship) {
  io::Json json{{"name", ship.name}};
  for (const EffectEntry& effect : ship.effects) json["effects"].push_back(effect.type);
  return json;
}

// An effect has parameters, so that --effect takes a file; its bare name is a likely mistake.
void require_effect_file(const std::string& file) {
  std::error_code error;
  if (file == "-" || file.find('/') != std::string::npos || file.ends_with(".json") ||
      std::filesystem::exists(file, error))
    return;
  const std::vector<std::string> known = effect_names();
  if (std::ranges::find(known, file) != known.end())
    throw UsageError(
        fmt::format("--effect: no file '{0}'; the effect of this name needs a file with its parameters, "
                    "{{\"type\": \"{0}\", ...}}: 'mmg-sim effects {0}' lists them",
                    file));
  throw UsageError(fmt::format("--effect: no file '{}', expected a JSON file; 'mmg-sim effects' lists the effects{}",
                               file, did_you_mean(file, known)));
}

// prediction.json of a replay, without what its run alone knows.
io::Json prediction_summary(const SimOptions& opt, const TimeGrid& grid) {
  return {{"sampling", "single"},
          {"members", 0},
          {"particles", 1},
          {"steps", opt.restart_steps},
          {"time_step_s", grid.sample_s}};
}

// All that decides the predictions of a replay but the recordings.
std::string generation_of(const SimOptions& opt, const Ship& ship, const TimeGrid& grid) {
  io::Json json = prediction_summary(opt, grid);
  json["version"] = LEEWAY_VERSION;
  json["dt_s"] = grid.dt_s;
  json["hold"] = opt.hold;
  json["ship"] = input_sha256(ship.file);
  for (const std::string& effect : opt.effects) json["effects"].push_back(input_sha256(effect));
  return json.dump();
}

std::size_t sequences_in(const Trajectory& recording, const RecordedInputs& inputs, const TimeGrid& grid,
                         std::size_t K) {
  std::size_t count = 0;
  for (const Samples& samples : resample(recording, inputs.channels(), inputs.has_wind(), grid.sample_s))
    count += test_sequences(samples.size(), static_cast<Eigen::Index>(K)).size();
  return count;
}

// Predictions of the recordings that hold a sequence.
void predict_sequences(const CLI::App& app, const SimOptions& opt, const Ship& ship,
                       const std::vector<Trajectory>& recordings, const std::vector<RecordedInputs>& inputs,
                       const TimeGrid& grid, const std::set<std::string>& initial_states) {
  std::vector<std::string> files, paths, too_short;
  for (const Trajectory& recording : recordings) {
    files.push_back(recording.name + ".csv");
    paths.push_back(recording.file);
  }
  std::optional<io::ResultFolder> folder;
  if (opt.output != "-") folder.emplace(opt.output, "prediction.json", files, generation_of(opt, ship, grid));
  inputs_of(opt).keep_from(folder ? folder->outputs() : std::vector<std::string>{opt.output});
  std::vector<std::size_t> long_enough;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    if (sequences_in(recordings[i], inputs[i], grid, opt.restart_steps) > 0)
      long_enough.push_back(i);
    else
      too_short.push_back(recordings[i].file);
  }
  if (long_enough.empty())
    throw InputError(recordings.front().file,
                     fmt::format("no recording holds {} points {} s apart without a gap; choose fewer --restart-steps",
                                 opt.restart_steps, grid.sample_s));
  tell_skipped(too_short, recordings.size(), opt.restart_steps, grid.sample_s);
  if (!folder) {
    io::PredictionWriter writer("-");
    for (const std::size_t i : long_enough)
      replay_sequences(ship, recordings[i], inputs[i], grid, opt.restart_steps, writer);
    return writer.commit();
  }
  folder->begin();
  for (const std::size_t i : long_enough) {
    io::PredictionWriter writer(folder->path(files[i]));
    replay_sequences(ship, recordings[i], inputs[i], grid, opt.restart_steps, writer);
    writer.commit();
    folder->add(files[i]);
  }
  io::Json summary = prediction_summary(opt, grid);
  summary["initial_state"] = initial_states.size() == 1 ? *initial_states.begin() : "mixed";
  summary["provenance"] = simulation_provenance(app, opt, ship, paths, {});
  folder->commit(std::move(summary));
}

void run_replay(const CLI::App& app, const SimOptions& opt) {
  TimeGrid grid = opt.grid;
  grid.duration_s = grid.sample_s;
  grid.check();
  if (opt.prediction != (opt.restart_steps > 0)) throw UsageError("--prediction and --restart-steps belong together");
  const bool has_other_columns = opt.recorded != RecordedColumns();
  if (opt.prediction && !(opt.noise.empty() && opt.truth.empty() && opt.indices.empty() && !has_other_columns))
    throw UsageError("--noise, --truth, --record-... and --indices do not apply to --prediction");
  std::vector<std::string> paths;
  std::set<std::string> initial_states;
  for (const io::RecordingFile& file : io::expand_recordings(opt.recordings)) {
    paths.push_back(file.path);
    initial_states.emplace(io::word(file.states));
  }
  if (!opt.prediction && paths.size() != 1)
    throw UsageError("one recording at a time, except with --restart-steps and --prediction");
  if (!opt.prediction) check_outputs(opt);

  const Ship ship = read_ship_with_effects(opt);
  std::vector<Trajectory> recordings = read_recordings(paths, opt.columns, opt.common.jobs, false, opt.prediction);
  add_revolutions(recordings, ship);
  std::vector<RecordedInputs> inputs;
  for (const Trajectory& recording : recordings) {
    inputs.emplace_back(recording, ship, opt.hold ? InputInterpolation::hold : InputInterpolation::linear);
    warn_all(inputs.back().notices());
    if (const auto notice = wind_notice(ship, recording)) warn_all({*notice});
  }
  if (!opt.prediction) {
    warn_all(holes_to_drive_through(recordings[0], grid));
    if (!opt.indices.empty()) {
      const Trajectory every_step = replay(ship, recordings[0], inputs[0], {grid.dt_s, grid.dt_s, grid.dt_s});
      const Trajectory truth = replay(ship, recordings[0], inputs[0], grid);
      begin_outputs(opt);
      write_indices(app, opt, ship, every_step, {"replay", 0.0, 0.0, {}, 0.0}, {{"dt_s", grid.dt_s}});
      return write_result(app, opt, ship, truth, paths);
    }
    const Trajectory truth = replay(ship, recordings[0], inputs[0], grid);
    begin_outputs(opt);
    return write_result(app, opt, ship, truth, paths);
  }

  predict_sequences(app, opt, ship, recordings, inputs, grid, initial_states);
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
      ->take_all()
      ->allow_extra_args(false);  // recordings that follow are none of its
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
  sub.add_option("--record-bow-thruster", opt.recorded.bow_thruster,
                 "n_bt_rps, or i_bt in its place: the pitch current of its drive, where the ship states it")
      ->check(CLI::IsMember(RecordedColumns::bow_thruster_words()))
      ->capture_default_str();
  sub.add_option("--record-wind", opt.recorded.wind, "both, or the true or the apparent wind alone")
      ->check(CLI::IsMember(RecordedColumns::wind_words()))
      ->capture_default_str();
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
  json["provenance"]["ship"] = named(ship);
  io::write_text(opt.indices, io::to_text(json));
  if (!json.contains("indices")) return;
  if (const std::vector<std::string> missing = not_reached(json["indices"]); !missing.empty())
    spdlog::warn("null in the indices, since this run of {} s did not reach or did not determine it: {}",
                 every_step[Channel::t].back() - every_step[Channel::t].front(), fmt::join(missing, ", "));
}

void check_outputs(const SimOptions& opt) {
  if ((opt.output == "-") + (opt.truth == "-") + (opt.indices == "-") > 1)
    throw UsageError("only one of --output, --truth and --indices can be the standard output");
  inputs_of(opt).keep_from(
      {opt.output, opt.truth, opt.indices, io::provenance_path(opt.output), io::provenance_path(opt.truth)});
}

void begin_outputs(const SimOptions& opt) {
  if (opt.truth.empty() && opt.indices.empty()) return;
  for (const std::string& path : {opt.output, opt.truth})
    if (!path.empty()) io::remove_described(path);  // throws where it cannot be written
  if (!opt.indices.empty()) io::remove_output(opt.indices);
}

io::Json simulation_provenance(const CLI::App& app, const SimOptions& opt, const Ship& ship,
                               const std::vector<std::string>& recordings,
                               const std::vector<std::string>& also_leave_out) {
  std::vector<std::string> inputs{ship.file};
  inputs.insert(inputs.end(), opt.effects.begin(), opt.effects.end());
  if (!opt.schedule.empty()) inputs.push_back(opt.schedule);
  inputs.insert(inputs.end(), recordings.begin(), recordings.end());
  if (!opt.columns.empty()) inputs.push_back(io::find_config("columns", opt.columns));
  if (!opt.noise.empty()) inputs.push_back(io::find_config("noise", opt.noise));
  io::Json json = provenance(app, opt.common, inputs, also_leave_out);
  json["ship"] = named(ship);
  return json;
}

void write_result(const CLI::App& app, const SimOptions& opt, const Ship& ship, Trajectory truth,
                  const std::vector<std::string>& recordings) {
  const ObservationNoise noise = opt.noise.empty() ? ObservationNoise{} : read_noise(opt.noise);
  complete_truth(truth, opt.recorded, ship);
  const io::Json made_by = simulation_provenance(app, opt, ship, recordings, {"--truth", "--indices"});
  if (!opt.truth.empty()) io::write_described(opt.truth, io::trajectory_text(truth), made_by);
  Trajectory recording = observed(truth, noise, {opt.common.seed, "observation noise"});
  leave_recorded(recording, opt.recorded);
  io::write_described(opt.output, io::trajectory_text(recording), made_by);
}

Ship read_ship_with_effects(const SimOptions& opt) {
  Ship ship = read_ship(opt.ship);
  coefficient_law(ship);  // throws for an uncertainty of what is no coefficient
  std::string added;
  for (const std::string& file : opt.effects) {
    require_effect_file(file);
    for (EffectEntry& effect : read_effects(file)) {
      added += (added.empty() ? "" : ", ") + effect.type;
      ship.effects.push_back(std::move(effect));
    }
  }
  if (!added.empty()) ship.name += " with " + added;  // results are of another ship than the file's
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
