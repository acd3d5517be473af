#include <cstdio>
#include <filesystem>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "core/errors.hpp"
#include "gap/explain.hpp"
#include "gap/explain_json.hpp"
#include "gap/report_html.hpp"
#include "gap/summary.hpp"
#include "io/dataset_json.hpp"
#include "io/files.hpp"

using namespace leeway;

namespace {

struct Options {
  std::string ship, columns, output;
  std::vector<std::string> recordings, heldout;
  bool no_correct = false, fail_on_mismatch = false;
  double false_alarm = 0.01, step_s = 0.0;
  cli::CommonOptions common;
};

void add_options(CLI::App& app, Options& o) {
  app.add_option("recordings", o.recordings, "recordings: CSV files, or a dataset.json or dataset.json#SET")
      ->required();
  app.add_option("--ship", o.ship, "the simulator: a ship's JSON file or a shipped name")->required();
  app.add_option("--holdout", o.heldout,
                 "recordings that judge the result and that nothing is fitted to (default: recordings, or blocks of a "
                 "few, are left out in turn)");
  app.add_option("--columns", o.columns, "columns map of the recordings (JSON), or the name of a shipped one");
  app.add_flag("--no-correct", o.no_correct, "leave the sensor faults that are found in the recordings");
  app.add_option("--false-alarm", o.false_alarm, "rate of finding something where there is nothing")
      ->check(cli::in_range(1e-4, 0.2))
      ->capture_default_str();
  app.add_option("--step-s", o.step_s,
                 "time grid of the filter [s], rounded to whole samples (default: 2 sqrt(L_pp/g))")
      ->check(cli::positive());
  app.add_flag("--fail-on-mismatch", o.fail_on_mismatch, "exit code 1 where something is missing");
  app.add_option("-o,--output", o.output, "folder for report.json, report.html and ship.json")->required();
  app.footer(
      "ship.json is the simulator with what was missing: mmg-sim runs it as it is. Exit codes: 0 done, whatever the\n"
      "verdict; 1 computation failed, or a mismatch with --fail-on-mismatch; 2 wrong command line, 3 a file's "
      "contents\n"
      "are wrong, 4 a file cannot be read or written. Method and results: docs/gap-explain.md");
  cli::add_common_options(app, o.common);
}

std::vector<std::string> paths_of(const std::vector<std::string>& given) {
  std::vector<std::string> files;
  for (const io::RecordingFile& file : io::expand_recordings(given)) files.push_back(file.path);
  return files;
}

}  // namespace

int main(int argc, char** argv) try {
  Options o;
  CLI::App app{"Say what physics a simulator lacks: name it, model it, and show the fit improve.", "gap-explain"};
  add_options(app, o);
  if (const auto exit_code = cli::parse(app, argc, argv, o.common)) return *exit_code;

  const Ship ship = read_ship(o.ship);
  const std::vector<std::string> files = paths_of(o.recordings), held_files = paths_of(o.heldout);
  for (const std::string& held : held_files)
    for (const std::string& file : files)
      if (std::filesystem::exists(held) && std::filesystem::exists(file) && std::filesystem::equivalent(held, file))
        throw UsageError(fmt::format("--holdout '{}' is also among the recordings that are fitted", held));
  std::vector<Trajectory> recordings = cli::read_recordings(files, o.columns, o.common.jobs);
  std::vector<Trajectory> heldout;
  if (!held_files.empty()) heldout = cli::read_recordings(held_files, o.columns, o.common.jobs);

  gap::GapExplainOptions options;
  options.locate.correct = !o.no_correct;
  options.locate.false_alarm = o.false_alarm;
  options.locate.step_s = o.step_s;
  options.locate.jobs = o.common.jobs;
  options.locate.seed = o.common.seed;
  gap::Explanation explanation;
  {
    cli::Progress progress("explaining", 1.0, o.common);
    options.locate.progress = [&](double done, const std::string& note) { progress.update(done, note); };
    explanation = gap::gap_explain(ship, recordings, heldout, options);
  }

  io::make_directories(o.output);
  const std::filesystem::path folder(o.output);
  std::vector<std::string> inputs{ship.file};
  inputs.insert(inputs.end(), files.begin(), files.end());
  inputs.insert(inputs.end(), held_files.begin(), held_files.end());
  io::Json json = gap::to_json(explanation);
  json["provenance"] = cli::provenance(app, o.common, inputs, {});
  io::write_text((folder / "ship.json").string(), io::to_text(gap::ship_with(io::read_json(ship.file), explanation)));
  io::write_text((folder / "report.html").string(),
                 gap::report_html(
                     explanation, "What " + ship.name + " lacks",
                     fmt::format("{}", fmt::join(json["provenance"]["command"].get<std::vector<std::string>>(), " "))));
  io::write_text((folder / "report.json").string(), io::to_text(json));
  cli::warn_all(explanation.notices);
  if (!o.common.quiet) fmt::print(stderr, "{}", gap::summary(explanation));
  return o.fail_on_mismatch && explanation.verdict == gap::Verdict::mismatch ? cli::kComputationFailed : cli::kOk;
} catch (...) {
  return cli::report_current_exception("gap-explain");
}
