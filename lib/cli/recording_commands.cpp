#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "cli/inputs.hpp"
#include "cli/simulator.hpp"
#include "core/errors.hpp"
#include "dynamics/recording_indices.hpp"
#include "foreign/proposal.hpp"
#include "io/csv.hpp"
#include "io/dataset_json.hpp"
#include "io/described_file.hpp"
#include "io/files.hpp"
#include "io/result_folder.hpp"
#include "io/trajectory_csv.hpp"

namespace leeway::cli {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> paths_of(const std::vector<std::string>& arguments) {
  std::vector<std::string> paths;
  for (const io::RecordingFile& file : io::expand_recordings(arguments)) paths.push_back(file.path);
  return paths;
}

// Several recordings go into a folder, and so does one where the output is called like a folder.
bool is_folder(const std::string& output, std::size_t recordings) {
  if (output == "-") return false;
  std::error_code error;
  if (recordings > 1 || output.ends_with('/') || fs::is_directory(output, error)) return true;
  return !fs::exists(output, error) && fs::path(output).extension().empty();
}

void import_into_folder(const CLI::App& app, const SimOptions& opt, const std::vector<std::string>& paths,
                        const std::vector<Trajectory>& recordings) {
  std::vector<std::string> files, inputs{io::find_config("columns", opt.columns)};
  for (const Trajectory& recording : recordings) files.push_back(recording.name + ".csv");
  inputs.insert(inputs.end(), paths.begin(), paths.end());
  io::ResultFolder folder(opt.output, "dataset.json", files);
  Inputs().config("columns", opt.columns).files(paths).keep_from(folder.outputs());
  folder.begin();
  io::Json listed = io::Json::array();
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    io::write_trajectory(folder.path(files[i]), recordings[i]);
    folder.add(files[i]);
    listed.push_back({{"file", files[i]}});
  }
  folder.commit({{"sets", {{{"name", "imported"}, {"recordings", listed}}}},
                 {"provenance", provenance(app, opt.common, inputs)}});
}

void run_import(const CLI::App& app, const SimOptions& opt) {
  const std::vector<std::string> paths = paths_of(opt.recordings);
  const bool into_folder = is_folder(opt.output, paths.size());
  if (paths.size() > 1 && !into_folder) throw UsageError("several recordings go into a folder: give --output DIR");
  if (!into_folder)
    Inputs().config("columns", opt.columns).files(paths).keep_from({opt.output, io::provenance_path(opt.output)});
  const std::vector<Trajectory> recordings = read_recordings(paths, opt.columns, opt.common.jobs);
  if (into_folder) return import_into_folder(app, opt, paths, recordings);
  io::write_described(opt.output, io::trajectory_text(recordings.front()),
                      provenance(app, opt.common, {io::find_config("columns", opt.columns), paths.front()}));
}

void run_columns(const SimOptions& opt) {
  const std::string& raw = opt.recordings.front();
  if (raw == "-") throw UsageError("a map is proposed for a file that is read twice; got '-'");
  Inputs().files({raw}).keep_from({opt.output});
  const foreign::Proposal proposal = foreign::propose_columns_map(raw);
  for (const std::string& note : proposal.unknowable) spdlog::warn("{}: {}", raw, note);
  io::write_text(opt.output, foreign::map_text(proposal));
}

void run_indices(const CLI::App& app, const SimOptions& opt, const RecordingIndexOptions& indices) {
  if (!opt.ship.empty() && indices.length_m) throw UsageError("--ship and --length-m exclude each other");
  const std::vector<std::string> paths = paths_of(opt.recordings);
  Inputs().config("ships", opt.ship).config("columns", opt.columns).files(paths).keep_from({opt.output});
  RecordedShip recorded{indices.length_m, 1.0, std::nullopt};
  io::Json json;
  std::vector<std::string> inputs;
  if (!opt.ship.empty()) {
    const Ship ship = read_ship(opt.ship);
    recorded = recorded_ship(ship);
    json["ship"] = {{"name", ship.name}, {"L_pp_m", ship.particulars.L_pp}, {"scale", ship.scale}};
    inputs.push_back(ship.file);
  } else {
    json["length_m"] = indices.length_m ? io::Json(*indices.length_m) : io::Json();
  }
  json["recordings"] = io::Json::array();
  std::string text;
  std::vector<std::string> notices;
  for (const Trajectory& recording : read_recordings(paths, opt.columns, opt.common.jobs)) {
    json["recordings"].push_back(recording_indices(recording, recorded, notices));
    text += recording_indices_text(json["recordings"].back());
  }
  warn_all(notices);
  inputs.insert(inputs.end(), paths.begin(), paths.end());
  if (!opt.columns.empty()) inputs.push_back(io::find_config("columns", opt.columns));
  json["provenance"] = provenance(app, opt.common, inputs);
  io::write_text(opt.output, indices.json ? io::to_text(json) : text);
}

void add_columns(CLI::App& sub, SimOptions& opt) {
  sub.add_option("--columns", opt.columns,
                 fmt::format("columns map (JSON) of foreign recordings, or its name: {}",
                             fmt::join(io::config_names("columns"), ", ")));
}

}  // namespace

Command add_import_command(CLI::App& app, SimOptions& opt) {
  CLI::App* sub = app.add_subcommand("import", "write foreign recordings in leeway's form, through a columns map");
  sub->add_option("recordings", opt.recordings, "recordings as they lie, also compressed with gzip; '-' for stdin")
      ->required();
  add_columns(*sub, opt);
  sub->get_option("--columns")->required();
  add_output(*sub, opt,
             "trajectory (CSV); for several recordings a folder for NAME.csv and dataset.json; '-' for stdout");
  return {sub, [&app, &opt] { run_import(app, opt); }};
}

Command add_columns_command(CLI::App& app, SimOptions& opt) {
  CLI::App* sub = app.add_subcommand(
      "columns", "propose a columns map for a foreign recording, from names, units and the kinematics: to be checked");
  sub->add_option("recording", opt.recordings, "recording as it lies, also compressed with gzip")
      ->required()
      ->expected(1);
  add_output(*sub, opt, "columns map (JSON), '-' for stdout");
  return {sub, [&opt] { run_columns(opt); }};
}

Command add_indices_command(CLI::App& app, SimOptions& opt, RecordingIndexOptions& indices) {
  CLI::App* sub = app.add_subcommand(
      "indices", "read overshoots, advance, transfer, tactical diameter and IMO's criteria off recorded maneuvers");
  sub->add_option("recordings", opt.recordings,
                  "recordings or simulations (CSV), dataset.json or dataset.json#SET; '-' for stdin")
      ->required();
  sub->add_option("--ship", opt.ship, "the ship that made them (JSON), or the name of a shipped one");
  sub->add_option("--length-m", indices.length_m,
                  "L_pp of that ship, in place of --ship [m] [default: lengths in meters]")
      ->check(in_range(0.1, 1000.0));
  add_columns(*sub, opt);
  sub->add_flag("--json", indices.json, "all indices as JSON, in place of a table");
  add_output(*sub, opt, "where they go, '-' for stdout");
  return {sub, [&app, &opt, &indices] { run_indices(app, opt, indices); }};
}

}  // namespace leeway::cli
