#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "cli/inputs.hpp"
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "core/errors.hpp"
#include "ensemble/calibration.hpp"
#include "ensemble/prediction_run.hpp"
#include "io/dataset_json.hpp"
#include "io/result_folder.hpp"

using namespace leeway;

namespace {

struct Options {
  std::vector<std::string> arguments;  // MODEL_DIR, then recordings; with --baseline recordings only
  std::string output = "-", sampling = "ts-inf", baseline, columns, initial_state = "true", kernel = "auto";
  int particles = 100, steps = 0, use_members = 0;
  double time_step_s = 1.0;
  bool fitted = false, no_disturbance = false, no_initial_error = false, no_calibration = false;
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
  app.add_flag("--no-disturbance", o.no_disturbance, "particles without the disturbance of the model's calibration");
  app.add_flag(
      "--no-initial-error", o.no_initial_error,
      "particles start from the recorded velocity itself, not from draws around it; from the truth they always "
      "start without an error");
  app.add_flag("--no-calibration", o.no_calibration,
               "leave the model's calibration.json unread: no disturbance, no initial error, no radii");
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
  app.add_option("--kernel", o.kernel, "auto, avx512, avx2 or portable")->capture_default_str();
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
  for (const char* option : {"--particles", "--sampling", "--initial-state", "--use-members", "--kernel",
                             "--no-disturbance", "--no-initial-error", "--no-calibration"}) {
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

// Files that the predictions start from: the truth where a data set has it, unless the command line says otherwise.
//   estimates  the model has an initial-state network
struct StartFiles {
  std::vector<std::string> paths;
  std::set<std::string> true_paths;  // those whose states have no error
  std::set<std::string> states;      // that they hold
};
StartFiles start_files_of(const Options& o, bool estimates) {
  StartFiles files;
  for (const io::RecordingFile& file : io::expand_recordings(o.arguments)) {
    const bool from_truth = o.initial_state == "true" && !o.fitted && !file.truth.empty();
    files.paths.push_back(from_truth ? file.truth : file.path);
    if (from_truth || file.states == io::States::truth) files.true_paths.insert(files.paths.back());
    files.states.emplace(o.fitted && estimates ? "estimate" : io::word(from_truth ? io::States::truth : file.states));
  }
  return files;
}

// Makes what predicts sequences for one thread: particles of the model, its fitted rollout, or the baseline. The
// arguments outlive it.
std::function<ensemble::SequencePredictor()> predictor_factory(const Options& o,
                                                               const std::optional<ensemble::Ensemble>& model,
                                                               const ensemble::PredictionOptions& options) {
  return [&]() -> ensemble::SequencePredictor {
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
}

double recorded_s_of(std::span<const Trajectory> recordings, double dt_s) {
  double sum_s = 0.0;
  for (const Trajectory& recording : recordings)
    sum_s += recording[Channel::t].back() - recording[Channel::t].front() + dt_s;
  return sum_s;
}

// The folder of the predictions. Those of other recordings by the same model and options may stand beside these.
//   model_folder  empty for a baseline
std::unique_ptr<io::ResultFolder> result_folder(const Options& o, const std::string& model_folder,
                                                const std::vector<Trajectory>& recordings,
                                                const std::string& generation) {
  cli::Inputs inputs;
  inputs.recordings(o.arguments).config("columns", o.columns);
  if (!model_folder.empty()) inputs.folder(model_folder);
  if (o.output == "-") {
    inputs.keep_from({o.output});
    return nullptr;
  }
  std::vector<std::string> files;
  files.reserve(recordings.size());
  for (const Trajectory& recording : recordings) files.push_back(recording.name + ".csv");
  auto folder = std::make_unique<io::ResultFolder>(o.output, "prediction.json", files, generation);
  inputs.keep_from(folder->outputs());
  return folder;
}

// The calibration of the model's folder that particles have.
std::optional<ensemble::Calibration> calibration_of(const Options& o, const std::string& model_folder,
                                                    const std::optional<ensemble::Ensemble>& model) {
  if (!model || o.fitted || o.no_calibration) return std::nullopt;
  return ensemble::read_calibration(model_folder, model->header());
}

// What the particles of a recording have besides their members.
void take_noise(const Options& o, const std::optional<ensemble::Ensemble>& model,
                const std::optional<ensemble::Calibration>& calibration, bool starts_from_truth,
                ensemble::PredictionOptions& options) {
  if (!calibration) return;
  options.draws_inputs = !o.no_disturbance && model->header().config.inputs == InputPath::linear;
  if (!o.no_disturbance) options.disturbance = calibration->disturbance;
  options.initial_sd = o.no_initial_error || starts_from_truth ? Vec3<double>::Zero() : calibration->sensor_sd;
}

// prediction.json, beside the predictions of a folder.
//   initial_states  the words for them
io::Json summary(const Options& o, const std::optional<ensemble::Ensemble>& model, int K, double dt_s,
                 const std::set<std::string>& initial_states, const std::optional<ensemble::Calibration>& calibration,
                 const ensemble::PredictionReport& report, io::Json provenance) {
  io::Json json{{"sampling", !o.baseline.empty() ? o.baseline
                             : o.fitted          ? "fitted"
                                                 : o.sampling},
                {"members", model ? model->members() : 0},
                {"particles", !model     ? 1
                              : o.fitted ? model->members()
                                         : o.particles},
                {"steps", K},
                {"time_step_s", dt_s},
                {"initial_state", initial_states.size() == 1 ? *initial_states.begin() : "mixed"},
                {"particles_out_of_bounds", report.out_of_bounds},
                {"provenance", std::move(provenance)}};
  if (calibration) {
    json["disturbance"] = !o.no_disturbance;
    json["initial_error"] = !o.no_initial_error;
    json["radii"] = ensemble::to_json(calibration->radii);
  }
  return json;
}

// All that decides predictions but the recordings.
std::string generation_of(const Options& o, const std::optional<ensemble::Ensemble>& model,
                          const std::optional<ensemble::Calibration>& calibration, int K, double dt_s) {
  io::Json json =
      summary(o, model, K, dt_s, {}, calibration, {}, {{"version", LEEWAY_VERSION}, {"seed", o.common.seed}});
  json["training_id"] = model ? model->header().training_id : "";
  json["kernel"] = model ? model->kernels().name : "";
  json["initial_state"] = o.initial_state;
  return json.dump();
}

}  // namespace

int main(int argc, char** argv) try {
  Options o;
  CLI::App app{"Propagate particles through a trained ensemble and write them as CSV.", "ens-predict"};
  add_options(app, o);
  if (const auto exit_code = cli::parse(app, argc, argv, o.common)) return *exit_code;
  check_combination(app, o);

  std::optional<ensemble::Ensemble> model;
  const std::string model_folder = o.baseline.empty() ? o.arguments.front() : "";
  if (o.baseline.empty()) {
    model.emplace(model_folder, o.use_members, nn::kernels(o.kernel));
    o.arguments.erase(o.arguments.begin());
    cli::warn_all(model->notices());
  }
  const ensemble::TrainingConfig config = model ? model->header().config : ensemble::TrainingConfig{};
  const std::optional<ensemble::Calibration> calibration = calibration_of(o, model_folder, model);
  const auto [paths, true_paths, initial_states] = start_files_of(o, model && config.initial_state_net);
  std::vector<Trajectory> recordings = cli::read_recordings(paths, o.columns, o.common.jobs);
  if (model && model->base() != nullptr) model->base()->prepare(recordings);

  const double dt_s = model ? config.time_step_s : o.time_step_s;
  const int K = o.steps > 0 ? o.steps : config.steps;
  const std::vector<Channel> actuators = model ? model->header().inputs.sampled_actuators() : std::vector<Channel>{};
  const bool wind = model && model->header().inputs.wind;
  ensemble::PredictionOptions options{o.particles,
                                      o.sampling == "ts1" ? ensemble::Sampling::ts1 : ensemble::Sampling::ts_infinity,
                                      config.integrator_predict, o.common.seed};
  const auto make_predictor = predictor_factory(o, model, options);
  const auto folder = result_folder(o, model_folder, recordings, generation_of(o, model, calibration, K, dt_s));
  if (folder) folder->begin();
  std::optional<io::PredictionWriter> writer;
  if (!folder) writer.emplace("-");
  ensemble::PredictionReport report;
  double left_out_s = 0.0, total_s = 0.0;
  std::vector<std::string> too_short;
  {
    cli::Progress progress("ens-predict", recorded_s_of(recordings, dt_s), o.common,
                           cli::Progress::Lines::of_long_work);
    for (const Trajectory& recording : recordings) {
      if (model) warn_of_constants(recording, model->header().inputs);
      take_noise(o, model, calibration, true_paths.contains(recording.file), options);
      const std::vector<Samples> stretches =
          resample(recording, actuators, wind, dt_s, config.resampling, config.inputs);
      const std::vector<ensemble::SequenceTask> tasks = ensemble::sequences_of(stretches, K, o.fitted);
      const double predicted_s = static_cast<double>(tasks.size()) * K * dt_s;
      const double recorded_s = recorded_s_of({&recording, 1}, dt_s);
      if (!o.fitted) left_out_s += std::max(0.0, recorded_s - predicted_s);
      total_s += recorded_s;
      if (tasks.empty()) {
        too_short.push_back(recording.file);
        continue;
      }
      if (folder) writer.emplace(folder->path(recording.name + ".csv"));
      ensemble::write_predictions(
          tasks, static_cast<std::size_t>(o.particles), o.common.jobs, make_predictor, *writer, report,
          [&](std::size_t more) { progress.advance(static_cast<double>(more) * K * dt_s, recording.name); });
      if (!folder) continue;
      writer->commit();
      folder->add(recording.name + ".csv");
    }
  }
  if (report.sequences == 0)
    throw InputError(
        recordings.front().file,
        fmt::format("no recording holds {} points {} s apart without a gap; choose fewer --steps", K, dt_s));
  cli::tell_skipped(too_short, recordings.size(), static_cast<std::size_t>(K), dt_s);
  if (!folder) writer->commit();
  cli::warn_all(report.notices);
  if (folder)
    folder->commit(
        summary(o, model, K, dt_s, initial_states, calibration, report, cli::provenance(app, o.common, paths)));
  spdlog::info("{}: {} sequences; {:.6g} of {:.6g} s at the ends of recordings or in gaps are in none",
               folder ? o.output : "standard output", report.sequences, left_out_s, total_s);
  return cli::kOk;
} catch (...) {
  return cli::report_current_exception("ens-predict");
}
