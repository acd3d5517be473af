#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "cli/gap_options.hpp"
#include "cli/inputs.hpp"
#include "cli/messages.hpp"
#include "cli/progress.hpp"
#include "core/errors.hpp"
#include "gap/gap_locate.hpp"
#include "gap/report/locate_json.hpp"
#include "gap/report/report_html.hpp"
#include "gap/report/residual_csv.hpp"
#include "gap/report/summary.hpp"
#include "io/files.hpp"
#include "io/outputs.hpp"
#include "io/result_folder.hpp"

using namespace leeway;

namespace {

constexpr const char* kResidual = ".residual.csv";

struct Options {
  cli::GapOptions gap;
  std::string model, output, write_corrected;
  int use_members = 0;
  double length_m = 0.0;
  cli::CommonOptions common;
};

void add_options(CLI::App& app, Options& o) {
  cli::add_gap_options(app, o.gap)->required(false);
  app.add_option("--model", o.model,
                 "the simulator, in place of --ship: the model directory of a trained ensemble, whose spread counts as "
                 "uncertainty");
  app.add_option("--use-members", o.use_members, "with --model: use the first M members only (default: all)")
      ->check(cli::at_least(1))
      ->needs("--model");
  app.add_option(
         "--length-m", o.length_m,
         "with --model: length of the ship [m], by which times scale (default: that of the base ship, if the model has "
         "one, else 3 m times the square of the ensemble's time step in s)")
      ->check(cli::positive())
      ->needs("--model");
  app.footer(
      "A recording needs t_s, u_mps, vm_mps, r_degps and the ship's actuators (mmg-sim show SHIP lists them), and "
      "should\n"
      "have x0_m, y0_m, psi_deg and the wind; with --model it needs what the ensemble was trained with. Exit codes: 0 "
      "done, whatever the verdict; 1 computation failed, 2 wrong\n"
      "command line, 3 a file's contents are wrong, 4 a file cannot be read or written. Method, results and rates:\n"
      "docs/gap-locate.md");
  app.add_option("--write-corrected", o.write_corrected, "folder for the recordings, corrected for the faults")
      ->excludes("--no-correct");
  app.add_option("-o,--output", o.output, "folder for locate.json, report.html and NAME.residual.csv")->required();
  cli::add_common_options(app, o.common);
}

// Residuals in the folder, of this run's recordings or of others.
std::vector<std::string> earlier_residuals(const Options& o) {
  std::vector<std::string> residuals = io::files_in(o.output);
  std::erase_if(residuals, [](const std::string& file) { return !file.ends_with(kResidual); });
  return residuals;
}

// locate.json and what belongs to it, and the corrected recordings, if they are wanted.
struct Results {
  std::unique_ptr<io::ResultFolder> folder, corrected;
};

Results result_folders(const Options& o, const std::vector<Trajectory>& recordings) {
  cli::Inputs inputs;
  inputs.recordings(o.gap.recordings).config("ships", o.gap.ship).config("columns", o.gap.columns);
  if (!o.model.empty()) inputs.folder(o.model);
  std::vector<std::string> files{"report.html"}, corrected;
  for (const Trajectory& recording : recordings) {
    files.push_back(recording.name + kResidual);
    corrected.push_back(recording.name + ".csv");
  }
  Results results;
  results.folder = std::make_unique<io::ResultFolder>(o.output, "locate.json", files);
  std::vector<std::string> outputs = results.folder->outputs();
  if (!o.write_corrected.empty()) {
    results.corrected = std::make_unique<io::ResultFolder>(o.write_corrected, "corrected.json", corrected);
    const std::vector<std::string> more = results.corrected->outputs();
    outputs.insert(outputs.end(), more.begin(), more.end());
  }
  inputs.keep_from(outputs);
  inputs.keep_from(earlier_residuals(o));  // which are removed
  return results;
}

std::shared_ptr<const gap::EnsembleSimulator> read_ensemble(const Options& o) {
  const std::filesystem::path folder = std::filesystem::path(o.model) / "";  // its name is that before the last slash
  ensemble::Ensemble ensemble(o.model, o.use_members, nn::kernels());
  if (o.length_m > 0.0 && ensemble.base() != nullptr)
    throw UsageError(fmt::format("--length-m: the base ship of {} has a length", o.model));
  return std::make_shared<const gap::EnsembleSimulator>(std::move(ensemble), folder.parent_path().filename().string(),
                                                        o.length_m);
}

}  // namespace

int main(int argc, char** argv) try {
  Options o;
  CLI::App app{
      "Compare recordings with the simulator: is there a mismatch, is it the sensors or the physics, and where does it "
      "sit?",
      "gap-locate"};
  add_options(app, o);
  if (const auto exit_code = cli::parse(app, argc, argv, o.common)) return *exit_code;

  if (o.gap.ship.empty() == o.model.empty())
    throw UsageError("expected exactly one of --ship and --model: the simulator that the recordings are compared with");
  const std::shared_ptr<const gap::EnsembleSimulator> ensemble = o.model.empty() ? nullptr : read_ensemble(o);
  const Ship ship = ensemble ? ensemble->ship() : read_ship(o.gap.ship);
  const std::vector<std::string> files = cli::recording_files(o.gap.recordings);
  std::vector<Trajectory> recordings =
      cli::read_recordings(files, o.gap.columns, o.common.jobs, !o.write_corrected.empty());
  io::require_can_make(o.output);
  if (!o.write_corrected.empty()) io::require_can_make(o.write_corrected);
  gap::GapLocateOptions options = cli::locate_options(o.gap, o.common);
  const Results results = result_folders(o, recordings);
  gap::Findings findings;
  {
    cli::Progress progress("locating", 1.0, o.common);
    options.progress = [&](double done, const std::string& note) { progress.update(done, note); };
    findings = ensemble ? gap::gap_locate(ensemble, recordings, options) : gap::gap_locate(ship, recordings, options);
  }

  findings.called = cli::called(o.gap, o.output);

  std::vector<std::string> inputs{ensemble ? (std::filesystem::path(o.model) / "ensemble.json").string() : ship.file};
  inputs.insert(inputs.end(), files.begin(), files.end());
  io::Json json = gap::to_json(findings);
  json["provenance"] = cli::provenance(app, o.common, inputs, {"--write-corrected"});
  json["provenance"]["policy"] = gap::policy_hash();
  results.folder->begin();
  // Residuals of an earlier version would stand beside a locate.json that does not know them.
  for (const std::string& file : earlier_residuals(o))
    if (std::none_of(findings.residuals.begin(), findings.residuals.end(),
                     [&](const gap::Residual& r) { return results.folder->path(r.recording + kResidual) == file; })) {
      std::filesystem::remove(file);
      cli::warn_all({fmt::format("{}: of an earlier run; removed", file)});
    }
  for (const gap::Residual& residual : findings.residuals)
    results.folder->write(residual.recording + kResidual, gap::residual_text(residual));
  if (results.corrected) {
    results.corrected->begin();
    for (const Trajectory& recording : recordings)
      results.corrected->write(recording.name + ".csv", io::trajectory_text(recording));
    results.corrected->commit({{"provenance", json["provenance"]}});
  }
  results.folder->write(
      "report.html",
      gap::report_html(
          findings, "Recordings against " + (ensemble ? ensemble->name() : ship.name),
          fmt::format("{}", fmt::join(json["provenance"]["command"].get<std::vector<std::string>>(), " "))));
  results.folder->commit(std::move(json));
  cli::warn_all(findings.notices);
  if (!o.common.quiet) cli::say(gap::summary(findings));
  return cli::kOk;
} catch (...) {
  return cli::report_current_exception("gap-locate");
}
