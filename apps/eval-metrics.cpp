#include <algorithm>
#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "cli/inputs.hpp"
#include "cli/messages.hpp"
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "core/errors.hpp"
#include "io/described_file.hpp"
#include "io/files.hpp"
#include "metrics/scores.hpp"

namespace {

using namespace leeway;

struct EvalOptions {
  cli::CommonOptions common;
  std::vector<std::string> predictions, truths;
  std::string columns, against, per_step, output = "-";
  double sigma_u_mps = 0.01, sigma_vm_mps = 0.01, sigma_r_degps = 0.1;
  double noise_u_mps = 0.0, noise_vm_mps = 0.0, noise_r_degps = 0.0;
};

}  // namespace

int main(int argc, char** argv) try {
  EvalOptions opt;
  CLI::App app{"Score probabilistic predictions against the truth.", "eval-metrics"};
  app.add_option("predictions", opt.predictions, "folders of prediction CSV files, such files, or '-' for stdin")
      ->required();
  app.add_option("--truth", opt.truths, "true trajectories: CSV files, dataset.json or dataset.json#SET")->required();
  app.add_option(
         "--against", opt.against,
         "truth or observations: which files of a data set the predictions are laid beside, or what other files "
         "are [default: the truth where a data set has it]")
      ->check(CLI::IsMember({"truth", "observations"}));
  app.add_option("--columns", opt.columns, "columns map of the truth files (JSON), or the name of a shipped one");
  app.add_option("--per-step", opt.per_step, "mean, spread, truth and distances of each step (CSV)");
  app.add_option("--sigma-u-mps", opt.sigma_u_mps, "sigma of u in L_fit [m/s]")
      ->check(cli::positive())
      ->capture_default_str();
  app.add_option("--sigma-vm-mps", opt.sigma_vm_mps, "sigma of v_m in L_fit [m/s]")
      ->check(cli::positive())
      ->capture_default_str();
  app.add_option("--sigma-r-degps", opt.sigma_r_degps, "sigma of r in L_fit [deg/s]")
      ->check(cli::positive())
      ->capture_default_str();
  app.add_option("--noise-u-mps", opt.noise_u_mps, "sd of the recordings' noise of u, where they are laid beside [m/s]")
      ->check(cli::not_negative())
      ->capture_default_str();
  app.add_option("--noise-vm-mps", opt.noise_vm_mps, "the same of v_m [m/s]")
      ->check(cli::not_negative())
      ->capture_default_str();
  app.add_option("--noise-r-degps", opt.noise_r_degps, "the same of r [deg/s]")
      ->check(cli::not_negative())
      ->capture_default_str();
  app.add_option("-o,--output", opt.output, "figures (JSON), '-' for stdout")->capture_default_str();
  cli::add_common_options(app, opt.common);
  if (const auto exit_code = cli::parse(app, argc, argv, opt.common)) return *exit_code;

  const auto streams = std::count(opt.predictions.begin(), opt.predictions.end(), "-") +
                       std::count(opt.truths.begin(), opt.truths.end(), "-");
  if (streams > 1) throw UsageError("'-' (the standard input) can be read only once");
  if (opt.per_step == "-" && opt.output == "-") throw UsageError("--per-step and --output cannot both be '-'");

  std::optional<io::ColumnsMap> columns;
  if (!opt.columns.empty()) columns = io::read_columns_map(opt.columns);
  ScoreOptions options;
  options.sigma = {opt.sigma_u_mps, opt.sigma_vm_mps, deg_to_rad(opt.sigma_r_degps)};
  options.noise = {opt.noise_u_mps, opt.noise_vm_mps, deg_to_rad(opt.noise_r_degps)};
  options.columns = columns ? &*columns : nullptr;
  options.jobs = opt.common.jobs;

  const PredictionSource source = find_predictions(opt.predictions);
  cli::Inputs inputs;
  inputs.recordings(opt.truths).config("columns", opt.columns).files(source.descriptions);
  for (const PredictionSource::File& file : source.files) inputs.files({file.path});
  inputs.keep_from({opt.output, opt.per_step, io::provenance_path(opt.per_step)});
  std::optional<io::States> against;
  if (!opt.against.empty()) against = opt.against == "truth" ? io::States::truth : io::States::observations;
  const Evaluation evaluation = [&] {
    const cli::Progress progress("eval-metrics", 1.0, opt.common, cli::Progress::Lines::of_long_work);
    return evaluate(source, truths_by_name(opt.truths, against), options);
  }();

  io::Json json = to_json(evaluation);
  json["provenance"] = cli::provenance(app, opt.common, input_files(source, evaluation), {"--per-step"});
  if (!source.provenance.empty()) json["provenance"]["predictions"] = source.provenance;
  cli::warn_all(notices(evaluation));
  if (!options.noise.isZero() && evaluation.overall.against != "observations")
    spdlog::warn("--noise-* counts where predictions are laid beside observations; here they are laid beside: {}",
                 evaluation.overall.against);
  if (!opt.per_step.empty()) io::remove_output(opt.output);  // it comes last: where it lies, the steps are of its run
  if (!opt.per_step.empty()) io::write_described(opt.per_step, per_step_text(evaluation), json["provenance"]);
  io::write_text(opt.output, io::to_text(json));
  if (!opt.common.quiet) cli::say(summary_text(evaluation));
  return cli::kOk;
} catch (...) {
  return leeway::cli::report_current_exception("eval-metrics");
}
