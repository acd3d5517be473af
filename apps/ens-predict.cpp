#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "cli/options.hpp"
#include "core/errors.hpp"
#include "ensemble/prediction_run.hpp"
#include "io/dataset_json.hpp"
#include "io/files.hpp"

using namespace leeway;

namespace {

struct Options {
  std::vector<std::string> arguments;  // MODEL_DIR, then recordings; with --baseline recordings only
  std::string output = "-", sampling = "ts-inf", baseline, columns, initial_state = "true", kernel = "auto";
  int particles = 100, steps = 0, use_members = 0;
  double time_step_s = 1.0;
  bool fitted = false;
  cli::CommonOptions common;
};

void add_options(CLI::App& app, Options& o) {
  app.add_option("inputs", o.arguments,
                 "MODEL_DIR, then test trajectories: CSV files, dataset.json or dataset.json#SET (with --baseline the "
                 "trajectories alone)")
      ->required();
  app.add_option("--particles", o.particles, "particles of each sequence")
      ->check(cli::at_least(1))
      ->capture_default_str();
  app.add_option("--steps", o.steps, "points K of a sequence, K - 1 steps (default: those of the training)")
      ->check(cli::at_least(2));
  app.add_option("--sampling", o.sampling, "ts-inf: a particle keeps its member; ts1: it draws one at every step")
      ->check(CLI::IsMember({"ts-inf", "ts1"}, CLI::ignore_case))
      ->capture_default_str();
  app.add_option("--use-members", o.use_members, "use the first M members only (default: all)")
      ->check(cli::at_least(1));
  app.add_option("--initial-state", o.initial_state,
                 "start from the true state where a dataset.json knows the truth, or always from the observed one")
      ->check(CLI::IsMember({"true", "observed"}))
      ->capture_default_str();
  app.add_flag("--fitted", o.fitted,
               "the fitted rollout of training windows instead of a prediction: each member from its own estimate of "
               "the initial state, by Euler; eval-metrics gives L_fit from it");
  app.add_option("--baseline", o.baseline, "hold: a prediction without a model that holds the initial velocity")
      ->check(CLI::IsMember({"hold"}));
  app.add_option("--time-step-s", o.time_step_s, "time step of the baseline [s]; a model brings its own")
      ->check(cli::positive())
      ->capture_default_str();
  app.add_option("--columns", o.columns, "columns map for foreign recordings: a JSON file or a shipped name");
  app.add_option("-o,--output", o.output, "folder for one prediction CSV per recording, '-' for one stream")
      ->capture_default_str();
  app.add_option("--kernel", o.kernel, "auto, avx512, amx, avx2 or portable")->capture_default_str();
  cli::add_common_options(app, o.common);
}

// Options that contradict each other end the program; those that a baseline or a fitted rollout does not need get a
// warning.
void check_combination(const CLI::App& app, const Options& o) {
  const bool baseline = !o.baseline.empty();
  if (!baseline && o.arguments.size() < 2)
    throw UsageError("expected MODEL_DIR and at least one test trajectory (or --baseline hold)");
  if (baseline && o.fitted) throw UsageError("--fitted needs a model, not --baseline");
  std::error_code error;
  if (baseline && std::filesystem::exists(std::filesystem::path(o.arguments.front()) / "ensemble.json", error))
    throw UsageError(fmt::format("{} is a model: with --baseline give the trajectories alone", o.arguments.front()));
  if (!baseline && app.count("--time-step-s") > 0)
    throw UsageError("--time-step-s is for --baseline; a model brings its own time step");
  if (!baseline && !o.fitted) return;
  for (const char* option : {"--particles", "--sampling", "--initial-state", "--use-members", "--kernel"}) {
    const bool used_by_fitted = option == std::string("--use-members") || option == std::string("--kernel");
    const bool used_by_baseline = option == std::string("--initial-state");
    if (app.count(option) > 0 && !(baseline ? used_by_baseline : used_by_fitted))
      spdlog::warn("{} has no effect with {}", option, baseline ? "--baseline" : "--fitted");
  }
}

void warn_of_constants(const Trajectory& recording, const ensemble::ModelInputs& inputs) {
  for (const auto& [channel, value] : inputs.constants)
    for (const double x : recording[channel])
      if (std::abs(x - value) > 1e-6 * std::max(1.0, std::abs(value))) {
        const bool in_base = std::count(inputs.base_actuators.begin(), inputs.base_actuators.end(), channel) > 0;
        spdlog::warn("{}: '{}' was constant in the training data and differs here: {}", recording.file,
                     column_name(channel),
                     in_base ? "only the base ship knows its effect" : "the model does not know its effect");
        break;
      }
}

}  // namespace

int main(int argc, char** argv) try {
  Options o;
  CLI::App app{"Propagate particles through a trained ensemble and write them as CSV.", "ens-predict"};
  add_options(app, o);
  if (const auto exit_code = cli::parse(app, argc, argv, o.common)) return *exit_code;
  check_combination(app, o);

  std::optional<ensemble::Ensemble> model;
  if (o.baseline.empty()) {
    model.emplace(o.arguments.front(), o.use_members, nn::kernels(o.kernel));
    o.arguments.erase(o.arguments.begin());
    cli::warn_all(model->notices());
  }
  std::vector<std::string> paths;
  for (const io::RecordingFile& file : io::expand_recordings(o.arguments))
    paths.push_back(o.initial_state == "true" && !o.fitted && !file.truth.empty() ? file.truth : file.path);
  const std::vector<Trajectory> recordings = cli::read_recordings(paths, o.columns, o.common.jobs);

  const ensemble::TrainingConfig config = model ? model->header().config : ensemble::TrainingConfig{};
  const double dt_s = model ? config.time_step_s : o.time_step_s;
  const int K = o.steps > 0 ? o.steps : config.steps;
  const std::vector<Channel> actuators = model ? model->header().inputs.sampled_actuators() : std::vector<Channel>{};
  const bool wind = model && model->header().inputs.wind;
  const ensemble::PredictionOptions options{
      o.particles, o.sampling == "ts1" ? ensemble::Sampling::ts1 : ensemble::Sampling::ts_infinity,
      config.integrator_predict, o.common.seed};
  const auto make_predictor = [&]() -> ensemble::SequencePredictor {
    std::shared_ptr<ensemble::EnsembleEvaluator> evaluator;
    if (model) evaluator = std::make_shared<ensemble::EnsembleEvaluator>(*model);
    return [&, evaluator](std::span<const ensemble::SequenceTask> tasks) {
      if (model && !o.fitted) return ensemble::predict_sequences(*evaluator, *model, tasks, options);
      std::vector<ensemble::SequencePrediction> predictions;
      for (const ensemble::SequenceTask& t : tasks)
        predictions.push_back(model ? ensemble::fitted_rollout(*evaluator, *model, *t.samples, t.range)
                                    : ensemble::hold_velocity(*t.samples, t.range));
      return predictions;
    };
  };

  const bool stream = o.output == "-";
  if (!stream) io::make_directories(o.output);
  std::optional<io::PredictionWriter> writer;
  if (stream) writer.emplace("-");
  ensemble::PredictionReport report;
  double left_out_s = 0.0, total_s = 0.0;
  for (const Trajectory& recording : recordings) {
    if (model) warn_of_constants(recording, model->header().inputs);
    if (model && model->base() != nullptr) model->base()->check(recording);
    const std::vector<Samples> stretches = resample(recording, actuators, wind, dt_s, config.resampling);
    const std::vector<ensemble::SequenceTask> tasks = ensemble::sequences_of(stretches, K, o.fitted);
    const double predicted_s = static_cast<double>(tasks.size()) * K * dt_s;
    const double recorded_s = recording[Channel::t].back() - recording[Channel::t].front() + dt_s;
    if (!o.fitted) left_out_s += std::max(0.0, recorded_s - predicted_s);
    total_s += recorded_s;
    if (tasks.empty()) {
      spdlog::warn("{}: holds no {} points {} s apart without a gap; nothing of it is predicted", recording.file, K,
                   dt_s);
      continue;
    }
    if (!stream) writer.emplace((std::filesystem::path(o.output) / (recording.name + ".csv")).string());
    ensemble::write_predictions(tasks, static_cast<std::size_t>(o.particles), o.common.jobs, make_predictor, *writer,
                                report);
    if (!stream) writer->commit();
  }
  if (report.sequences == 0)
    throw InputError(
        recordings.front().file,
        fmt::format("no recording holds {} points {} s apart without a gap; choose fewer --steps", K, dt_s));
  if (stream) writer->commit();
  cli::warn_all(report.notices);
  if (!stream) {
    io::Json json{{"sampling", !o.baseline.empty() ? o.baseline
                               : o.fitted          ? "fitted"
                                                   : o.sampling},
                  {"members", model ? model->members() : 0},
                  {"particles", !model     ? 1
                                : o.fitted ? model->members()
                                           : o.particles},
                  {"steps", K},
                  {"time_step_s", dt_s},
                  {"particles_out_of_bounds", report.out_of_bounds},
                  {"provenance", cli::provenance(app, o.common, paths)}};
    io::write_text((std::filesystem::path(o.output) / "prediction.json").string(), io::to_text(json));
  }
  spdlog::info("{}: {} sequences; {:.6g} of {:.6g} s at the ends of recordings or in gaps are in none",
               stream ? "standard output" : o.output, report.sequences, left_out_s, total_s);
  return cli::kOk;
} catch (...) {
  return cli::report_current_exception("ens-predict");
}
