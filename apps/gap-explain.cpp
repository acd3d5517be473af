#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "cli/gap_options.hpp"
#include "cli/inputs.hpp"
#include "cli/messages.hpp"
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "core/errors.hpp"
#include "effects/description.hpp"
#include "gap/compare/current_course.hpp"
#include "gap/gap_explain.hpp"
#include "gap/report/explain_json.hpp"
#include "gap/report/report_html.hpp"
#include "gap/report/summary.hpp"
#include "io/csv.hpp"
#include "io/files.hpp"
#include "io/result_folder.hpp"

using namespace leeway;

namespace {

struct Options {
  cli::GapOptions gap;
  std::string output;
  std::vector<std::string> heldout;
  bool fail_on_mismatch = false, calibrates = false, thorough = false;
  std::size_t campaigns = gap::kPolicy.bootstrap.campaigns;
  std::size_t refits = gap::kPolicy.compare.refitted, most_effects = gap::kPolicy.compare.most_effects;
  std::string area;
  std::optional<double> depth_m, rudder_deg, time_s;
  cli::CommonOptions common;
};

void add_options(CLI::App& app, Options& o) {
  cli::add_gap_options(app, o.gap);
  app.add_option("--holdout", o.heldout,
                 "recordings that judge the result and that nothing is fitted to (default: recordings, or blocks of a "
                 "few, are left out in turn)");
  CLI::Option* const thorough = app.add_flag(
      "--thorough", o.thorough,
      "make the stated probabilities true of campaigns like this one: they are simulated from what was found, and "
      "analyzed again, --jobs at a time; a batch job: on two cores 40 campaigns take 10 to 20 times as long as a run "
      "without");
  app.add_option("--campaigns", o.campaigns, "how many are simulated")
      ->needs(thorough)
      ->check(CLI::Range(std::size_t{1}, std::size_t{10000}))
      ->capture_default_str();
  CLI::Option* const calibrates = app.add_flag(
      "--calibrate", o.calibrates,
      "fit the ship's coefficients alone and name no effect: ship.json has the likeliest, given what the ship file "
      "states of them, and as coefficient_covariance what the recordings leave open");
  calibrates->excludes(thorough);
  app.add_option("--refits", o.refits,
                 "effects that are fitted, those first of which one linear step expects most; what is not fitted has "
                 "its share of the probability (report.json: not_fitted)")
      ->excludes(calibrates)
      ->check(CLI::Range(std::size_t{1}, std::size_t{100}))
      ->capture_default_str();
  app.add_option("--most-effects", o.most_effects, "largest number of effects that are named together")
      ->excludes(calibrates)
      ->check(CLI::Range(std::size_t{1}, std::size_t{6}))
      ->capture_default_str();
  const auto next = [&](const std::string& name, auto& value, const std::string& what) {
    return app.add_option(name, value, what)
        ->group("Limits of what is advised to be recorded next")
        ->excludes(calibrates);
  };
  next("--next-area-m", o.area,
       "length and width of the area, which may lie in any direction [m]: 300x120; or of a square: 300");
  next("--next-depth-m", o.depth_m, "depth of the water there [m] (default: as in the recordings)")
      ->check(cli::positive());
  next("--next-rudder-deg", o.rudder_deg, "largest rudder angle to either side [deg]")->check(cli::positive());
  next("--next-time-s", o.time_s, "time for all of it [s]")->check(cli::positive());
  app.add_flag("--fail-on-mismatch", o.fail_on_mismatch, "exit code 1 where something is missing");
  app.add_option("-o,--output", o.output, "folder for report.json, report.html and ship.json")->required();
  app.footer(
      "ship.json is the simulator with what was missing: mmg-sim runs it as it is. Exit codes: 0 done, whatever the\n"
      "verdict; 1 computation failed, or a mismatch with --fail-on-mismatch; 2 wrong command line, 3 a file's "
      "contents\n"
      "are wrong, 4 a file cannot be read or written. Method and results: docs/gap-explain.md");
  cli::add_common_options(app, o.common);
}

// "300x120": length and width [m] of an area; "300": of a square.
std::pair<double, double> area_of(const std::string& text) {
  const auto number = [&](const std::string& part) {
    double value = 0.0;
    if (!io::parse_number(part, value) || !(value > 0.0))
      throw UsageError(
          fmt::format("--next-area-m: expected length and width [m] as 300x120, or one of both, got '{}'", text));
    return value;
  };
  const std::size_t x = text.find('x');
  const double first = number(text.substr(0, x)), second = x == std::string::npos ? first : number(text.substr(x + 1));
  return std::minmax(first, second);
}

gap::NextLimits next_limits(const Options& o, const Ship& ship) {
  gap::NextLimits limits;
  limits.depth_m = o.depth_m;
  limits.rudder_deg = o.rudder_deg;
  limits.time_s = o.time_s;
  if (!o.area.empty()) std::tie(limits.width_m, limits.length_m) = area_of(o.area);
  for (const EffectDescription& effect : effect_catalogue())
    if (const double least_m = effect.parameters.front().low * ship.particulars.d;
        effect.info.changes_depth && o.depth_m && *o.depth_m < least_m)
      throw UsageError(fmt::format("--next-depth-m {:.4g}: expected at least {:.4g} m, {:.4g} times the draft of '{}'",
                                   *o.depth_m, least_m, effect.parameters.front().low, ship.name));
  return limits;
}

std::unique_ptr<io::ResultFolder> result_folder(const Options& o, const std::vector<Trajectory>& recordings) {
  cli::Inputs inputs;
  inputs.recordings(o.gap.recordings).recordings(o.heldout);
  inputs.config("ships", o.gap.ship).config("columns", o.gap.columns);
  std::vector<std::string> files{"report.html", "ship.json"};
  for (const Trajectory& recording : recordings) {
    files.push_back(gap::ship_file(recording.name));
    files.push_back(gap::current_file(recording.name));
  }
  auto folder = std::make_unique<io::ResultFolder>(o.output, "report.json", files);
  inputs.keep_from(folder->outputs());
  return folder;
}

}  // namespace

int main(int argc, char** argv) try {
  Options o;
  CLI::App app{"Say what physics a simulator lacks: name it, model it, and show the fit improve.", "gap-explain"};
  add_options(app, o);
  if (const auto exit_code = cli::parse(app, argc, argv, o.common)) return *exit_code;

  const Ship ship = read_ship(o.gap.ship);
  const std::vector<std::string> files = cli::recording_files(o.gap.recordings),
                                 held_files = cli::recording_files(o.heldout);
  for (const std::string& held : held_files)
    for (const std::string& file : files)
      if (std::error_code error; std::filesystem::equivalent(held, file, error))
        throw UsageError(fmt::format("--holdout '{}' is also among the recordings that are fitted", held));
  std::vector<Trajectory> recordings = cli::read_recordings(files, o.gap.columns, o.common.jobs);
  std::vector<Trajectory> heldout;
  if (!held_files.empty()) heldout = cli::read_recordings(held_files, o.gap.columns, o.common.jobs);

  io::require_can_make(o.output);
  const auto folder = result_folder(o, recordings);
  gap::GapExplainOptions options;
  options.locate = cli::locate_options(o.gap, o.common);
  options.calibrates = o.calibrates;
  options.refitted = o.refits;
  options.most_effects = o.most_effects;
  if (o.thorough) options.campaigns = o.campaigns;
  options.next = next_limits(o, ship);
  gap::Explanation explanation;
  {
    cli::Progress progress("explaining", 1.0, o.common);
    options.locate.progress = [&](double done, const std::string& note) { progress.update(done, note); };
    explanation = gap::gap_explain(ship, recordings, heldout, options);
  }

  explanation.findings.called = cli::called(o.gap, o.output);

  std::vector<std::string> inputs{ship.file};
  inputs.insert(inputs.end(), files.begin(), files.end());
  inputs.insert(inputs.end(), held_files.begin(), held_files.end());
  io::Json json = gap::to_json(explanation);
  json["provenance"] = cli::provenance(app, o.common, inputs, {});
  json["provenance"]["policy"] = gap::policy_hash();
  const io::Json ship_json = io::read_json(ship.file);
  folder->begin();
  folder->write("ship.json", io::to_text(gap::ship_with(ship_json, explanation)));
  for (const auto& [recording, effects] : explanation.effects_in)
    folder->write(gap::ship_file(recording), io::to_text(gap::ship_with(ship_json, explanation, recording)));
  for (const gap::CurrentPath& path : explanation.current_paths)
    folder->write(gap::current_file(path.recording), gap::path_text(path));
  folder->write("report.html",
                gap::report_html(
                    explanation, o.calibrates ? "The coefficients of " + ship.name : "What " + ship.name + " lacks",
                    fmt::format("{}", fmt::join(json["provenance"]["command"].get<std::vector<std::string>>(), " "))));
  folder->commit(std::move(json));
  cli::warn_all(explanation.notices);
  if (!o.common.quiet) cli::say(gap::summary(explanation));
  return o.fail_on_mismatch && explanation.verdict == gap::Verdict::mismatch ? cli::kComputationFailed : cli::kOk;
} catch (...) {
  return cli::report_current_exception("gap-explain");
}
