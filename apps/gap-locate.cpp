#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/gap_options.hpp"
#include "cli/progress.hpp"
#include "core/errors.hpp"
#include "gap/gap_locate.hpp"
#include "gap/locate_json.hpp"
#include "gap/report_html.hpp"
#include "gap/residual_csv.hpp"
#include "gap/summary.hpp"
#include "io/files.hpp"

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

std::string corrected_file(const Options& o, const Trajectory& recording) {
  return (std::filesystem::path(o.write_corrected) / (recording.name + ".csv")).string();
}

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
  app.add_option("--write-corrected", o.write_corrected, "folder for the recordings with the faults taken out")
      ->excludes("--no-correct");
  app.add_option("-o,--output", o.output, "folder for locate.json, report.html and NAME.residual.csv")->required();
  cli::add_common_options(app, o.common);
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
  for (const Trajectory& recording : recordings)
    for (const std::string& input : files)
      if (const std::string file = corrected_file(o, recording);
          !o.write_corrected.empty() && std::filesystem::exists(file) && std::filesystem::exists(input) &&
          std::filesystem::equivalent(input, file))
        throw UsageError(
            fmt::format("--write-corrected '{}' would write over the recording '{}'", o.write_corrected, input));
  gap::Findings findings;
  {
    cli::Progress progress("locating", 1.0, o.common);
    options.progress = [&](double done, const std::string& note) { progress.update(done, note); };
    findings = ensemble ? gap::gap_locate(ensemble, recordings, options) : gap::gap_locate(ship, recordings, options);
  }

  io::make_directories(o.output);
  if (!o.write_corrected.empty()) io::make_directories(o.write_corrected);
  const std::filesystem::path folder(o.output);
  std::vector<std::string> inputs{ensemble ? (std::filesystem::path(o.model) / "ensemble.json").string() : ship.file};
  inputs.insert(inputs.end(), files.begin(), files.end());
  io::Json json = gap::to_json(findings);
  json["provenance"] = cli::provenance(app, o.common, inputs, {"--write-corrected"});
  // Residuals of an earlier run would stand beside a locate.json that does not know them.
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (const std::string name = entry.path().filename().string(); entry.is_regular_file() && name.ends_with(kResidual))
      if (std::none_of(findings.residuals.begin(), findings.residuals.end(),
                       [&](const gap::Residual& r) { return r.recording + kResidual == name; })) {
        std::filesystem::remove(entry.path());
        cli::warn_all({fmt::format("{}: of an earlier run; removed", entry.path().string())});
      }
  for (const gap::Residual& residual : findings.residuals)
    io::write_text((folder / (residual.recording + kResidual)).string(), gap::residual_text(residual));
  if (!o.write_corrected.empty())
    for (const Trajectory& recording : recordings) io::write_trajectory(corrected_file(o, recording), recording);
  io::write_text((folder / "report.html").string(),
                 gap::report_html(
                     findings, "Recordings against " + (ensemble ? ensemble->name() : ship.name),
                     fmt::format("{}", fmt::join(json["provenance"]["command"].get<std::vector<std::string>>(), " "))));
  io::write_text((folder / "locate.json").string(), io::to_text(json));
  cli::warn_all(findings.notices);
  if (!o.common.quiet) fmt::print(stderr, "{}", gap::summary(findings));
  return cli::kOk;
} catch (...) {
  return cli::report_current_exception("gap-locate");
}
