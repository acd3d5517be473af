#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "cli/inputs.hpp"
#include "cli/interruption.hpp"
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "cli/training_status.hpp"
#include "core/errors.hpp"
#include "ensemble/base_preparation.hpp"
#include "ensemble/cross_fit.hpp"
#include "ensemble/ensemble_training.hpp"
#include "ensemble/training_differences.hpp"
#include "io/csv.hpp"
#include "io/dataset_json.hpp"
#include "io/files.hpp"
#include "io/outputs.hpp"

using namespace leeway;

namespace {

struct Options {
  std::vector<std::string> recordings, held_out;
  std::string config = "honest", output, status, calibrate, columns, base, kernel = "auto";
  std::optional<std::string> base_spread;
  int members = 0, member = -1, epochs = 0;
  bool resume = false, no_initial_state_net = false;
  double checkpoint_s = 30.0;
  cli::CommonOptions common;
};

void add_options(CLI::App& app, Options& o) {
  app.add_option("recordings", o.recordings, "training trajectories: CSV files, dataset.json or dataset.json#SET");
  app.add_option("--config", o.config,
                 fmt::format("training config: a JSON file or the name of a shipped one ({})",
                             fmt::join(io::config_names("train"), ", ")))
      ->capture_default_str();
  app.add_option("--members", o.members, "members of the ensemble (default: the config's)")->check(cli::at_least(1));
  app.add_option("--epochs", o.epochs, "passes over the data (default: the config's)")->check(cli::at_least(1));
  app.add_option("-o,--output", o.output, "model directory");
  app.add_option("--status", o.status,
                 "say how far the training in this model directory is, no recordings, base or output beside it");
  app.add_option(
      "--calibrate", o.calibrate,
      "find disturbance, sensor noise and radii of the whole ensemble in this model directory, whose members "
      "were trained on the same recordings; a run that trains all of them does it where its config says so");
  app.add_option("--member", o.member, "train this member alone, counted from 0, as another process trains the others")
      ->check(cli::not_negative());
  app.add_flag("--resume", o.resume, "keep finished members and continue from checkpoints");
  app.add_flag("--no-initial-state-net", o.no_initial_state_net, "start each window from the observed state");
  app.add_option(
      "--base", o.base,
      fmt::format("ship whose equations of motion the networks add to, instead of learning the whole: a JSON "
                  "file or a shipped name ({})",
                  fmt::join(io::config_names("ships"), ", ")));
  app.add_option("--base-spread", o.base_spread,
                 "let each member learn on a ship of its own, drawn from the base's stated uncertainty times this; 0: "
                 "all on the base itself; auto: inferred from the recordings (default: the config's)");
  app.add_option("--held-out", o.held_out, "trajectories whose loss is shown on the way; they are never trained on");
  app.add_option("--columns", o.columns, "columns map for foreign recordings: a JSON file or a shipped name");
  app.add_option("--checkpoint-s", o.checkpoint_s, "seconds between checkpoints; 0: after every optimizer step")
      ->check(cli::not_negative())
      ->capture_default_str();
  app.add_option("--kernel", o.kernel, "auto, avx512, avx2 or portable; the first two train to the same bits")
      ->capture_default_str();
  cli::add_common_options(app, o.common);
}

// Recordings of the arguments in the order of their names, so that a training is the same whatever the order on the
// command line; two of one name are refused. A data set without its set named may hold more than was meant.
std::vector<Trajectory> read_all(const std::vector<std::string>& arguments, const std::string& verb, const Options& o) {
  std::vector<std::string> paths;
  for (const std::string& argument : arguments) {
    std::set<std::string> sets;
    for (const io::RecordingFile& file : io::expand_recordings({argument})) {
      paths.push_back(file.path);
      sets.insert(file.set);
    }
    if (sets.size() > 1)
      spdlog::warn("{}: {} all its sets ({}); {}#SET names one of them", argument, verb, fmt::join(sets, ", "),
                   argument);
  }
  std::sort(paths.begin(), paths.end(), [](const auto& a, const auto& b) { return io::stem(a) < io::stem(b); });
  return cli::read_recordings(paths, o.columns, o.common.jobs);
}

// " loss 12.3 held-out 14.5", as far as they are known.
std::string losses(const ensemble::MemberProgress& progress) {
  std::string text;
  if (progress.loss) text += fmt::format(" loss {:.4g}", *progress.loss);
  if (progress.held_out_loss) text += fmt::format(" held-out {:.4g}", *progress.held_out_loss);
  return text;
}

std::string name_of(const std::optional<ensemble::BaseRecord>& base) {
  return base ? fmt::format("'{}' ({}, spread {:g})", base->name, base->sha256.substr(0, 8), base->spread) : "none";
}

// Of a base whose spread is yet to be found.
std::optional<ensemble::BaseRecord> record_of(const std::shared_ptr<const ensemble::BaseModel>& base) {
  if (!base) return std::nullopt;
  return ensemble::BaseRecord{base->ship().name, base->sha256()};
}

// --base-spread in place of what the config says.
void take_base_spread(const Options& o, ensemble::TrainingConfig& config) {
  if (!o.base_spread) return;
  if (o.base.empty()) throw UsageError("--base-spread needs --base, the ship whose uncertainty is meant");
  double spread = 0.0;
  if (*o.base_spread == "auto")
    config.base_spread = std::nullopt;
  else if (io::parse_number(*o.base_spread, spread) && spread >= 0.0)
    config.base_spread = spread;
  else
    throw UsageError(fmt::format("--base-spread: expected a number >= 0 or 'auto', got '{}'", *o.base_spread));
}

// What the recordings say of the base ship, and how many draws of it were none.
void tell_base(const Options& o, const ensemble::TrainingData& data,
               const std::optional<ensemble::BaseSpreadEstimate>& found) {
  if (found) {
    if (!data.config.base_spread)
      spdlog::info(
          "{}: by these recordings the base ship is {:.2g} times as wrong as it states (90 %: {:.2g} to {:.2g})",
          o.output, found->spread, found->low, found->high);
    for (const CoefficientFactor& by : found->factors)
      spdlog::debug("likeliest {}: times {:.3f}{}", by.name, by.factor,
                    by.shift == 0.0 ? "" : fmt::format(", plus {:.3g}", by.shift));
    spdlog::debug(
        "accelerations that no coefficient explains, per root of a second: {:.2g} m/s^2, {:.2g} m/s^2, "
        "{:.2g} deg/s^2",
        found->acceleration_noise(0), found->acceleration_noise(1), rad_to_deg(found->acceleration_noise(2)));
  }
  if (data.base_spread == 0.0) return;
  const ShipDraws draws = ensemble::draws_of_members(data, o.common.seed);
  int refused = 0;
  for (int member = 0; member < data.config.members; ++member) refused += draws.draw(member).refused;
  if (refused > 0)
    spdlog::info("{}: {} of {} draws of the base ship made no ship (too slow, or no steady turn) and were drawn anew",
                 o.output, refused, refused + data.config.members);
}

// A training writes and removes the files of a model directory.
void check_outputs(const Options& o) {
  cli::Inputs inputs;
  inputs.recordings(o.recordings).recordings(o.held_out).config("columns", o.columns);
  inputs.config("train", o.config).config("ships", o.base);
  std::vector<std::string> outputs;
  for (const std::string& file : io::files_in(o.output))
    if (ensemble::is_model_file(file)) outputs.push_back(file);
  inputs.keep_from(outputs);
}

// What the model directory says of its training files. Files of the same bytes weigh twice.
std::vector<ensemble::TrainingFile> training_files(const std::vector<Trajectory>& recordings) {
  std::vector<ensemble::TrainingFile> files;
  std::map<std::string, std::string> file_of_hash;
  for (const Trajectory& r : recordings) {
    files.push_back({r.file, cli::input_sha256(r.file), r.size()});
    const std::string& hash = files.back().sha256;
    if (hash.empty()) continue;
    if (const auto [other, is_new] = file_of_hash.emplace(hash, r.file); !is_new)
      spdlog::warn("{}: holds the same bytes as {}; what they record weighs twice in the training", r.file,
                   other->second);
  }
  return files;
}

// Throws UsageError where the folder holds an ensemble of another base, other data or other settings: nothing that may
// have taken days to train is replaced by a slip of the command line.
//   given  hash of the base ship's file as it was given; empty without one
void refuse_other_training(const Options& o, const ensemble::EnsembleHeader& wanted, const std::string& given,
                           bool is_prepared) {
  const auto existing = ensemble::read_header(o.output, true);
  if (!existing) return;
  const std::string way_out = fmt::format("choose another folder with -o, or remove '{}' first", o.output);
  const std::string its_base = !existing->base                         ? ""
                               : existing->base->stated_sha256.empty() ? existing->base->sha256
                                                                       : existing->base->stated_sha256;
  if (is_prepared ? existing->base != wanted.base : its_base != given)
    throw UsageError(fmt::format("{} holds an ensemble of another base: {}, not {}; {}", o.output,
                                 name_of(existing->base), name_of(wanted.base), way_out));
  const std::vector<std::string> differences = ensemble::training_differences(*existing, wanted);
  if (differences.empty() && (!is_prepared || existing->training_id == wanted.training_id)) return;
  throw UsageError(fmt::format("{} holds an ensemble of other data, settings or seed: {}; {}", o.output,
                               differences.empty() ? "the channels that are read of the same recordings differ"
                                                   : fmt::format("{}", fmt::join(differences, "; ")),
                               way_out));
}

// Data to train on, unless the folder holds an ensemble of others.
ensemble::TrainingData prepare(const Options& o, const std::vector<Trajectory>& recordings,
                               const ensemble::TrainingConfig& config,
                               const std::shared_ptr<const ensemble::BaseModel>& base,
                               const std::vector<ensemble::TrainingFile>& files) {
  refuse_other_training(o, {config, {}, o.common.seed, files, record_of(base), ""}, base ? base->sha256() : "", false);
  std::optional<ensemble::BaseSpreadEstimate> found;
  const auto prepared = [&] {
    const cli::Progress progress("ens-train: preparation", 1.0, o.common);  // minutes, where the base is fitted
    return ensemble::prepare_in_folder(o.output, recordings, config, base, o.common.seed, files, found, o.common.jobs);
  };
  ensemble::TrainingData data = prepared();
  cli::warn_all(data.notices);
  tell_base(o, data, found);
  return data;
}

// The folder's ensemble.json: new, or the one that this run belongs to.
ensemble::EnsembleHeader open_folder(const Options& o, const CLI::App& app, const ensemble::TrainingData& data,
                                     const std::vector<Trajectory>& recordings,
                                     std::vector<ensemble::TrainingFile> files, const ensemble::TrainingLock& lock) {
  std::vector<std::string> paths;
  paths.reserve(recordings.size() + 1);
  for (const Trajectory& r : recordings) paths.push_back(r.file);
  if (data.base) paths.push_back(data.base->ship().file);
  ensemble::EnsembleHeader header = ensemble::make_header(data, o.common.seed, std::move(files));
  const bool continues = o.resume || o.member >= 0;
  if (continues) {
    lock.share();
  } else if (!lock.is_alone()) {
    ensemble::refuse_owners(o.output);
    throw IoError(o.output, "another process begins a training here; wait until it is done, or choose another folder");
  }
  io::remove_leftovers(o.output);
  refuse_other_training(o, header, "", true);
  const auto existing = ensemble::read_header(o.output, true);
  if (!continues) ensemble::remove_training(o.output);
  const bool is_whole = existing && continues && ensemble::has_base_file(o.output, header);
  if (!is_whole || existing->config.members != header.config.members)
    ensemble::write_header(
        o.output, header,
        cli::provenance(app, o.common, paths, {"--member", "--resume", "--checkpoint-s", "--held-out"}),
        data.base.get(), data.stated.get());
  lock.share();
  // Between being alone and sharing another one may have begun.
  if (const auto now = ensemble::read_header(o.output, true); !now || now->training_id != header.training_id)
    throw IoError(o.output,
                  "another process has begun a training here; wait until it is done, or choose another folder");
  return header;
}

// Trains with a progress line; the mean loss of the members, or nothing where a signal stopped it.
std::optional<double> train(const Options& o, const ensemble::TrainingData& data,
                            const ensemble::EnsembleHeader& header, const ensemble::EnsembleTraining& training,
                            const nn::Kernels<float>& kernels) {
  std::vector<ensemble::MemberProgress> members(static_cast<std::size_t>(header.config.members));
  const auto count = static_cast<double>(training.members.size());
  {
    cli::Progress progress(
        fmt::format("ens-train: {} member{}", training.members.size(), training.members.size() == 1 ? "" : "s"),
        count * header.config.epochs, o.common);
    const auto report = [&](int number, const ensemble::MemberProgress& now) {
      ensemble::MemberProgress& member = members[static_cast<std::size_t>(number)];
      if (now.epochs_done - member.epochs_done > 1) progress.skip(now.epochs_done - member.epochs_done);
      member = now;
      double epochs = 0.0;
      for (const auto& m : members) epochs += m.epochs_done;
      progress.update(epochs, fmt::format("member {} epoch {}{}", number, now.epochs_done, losses(now)));
    };
    if (!ensemble::train_ensemble(data, header, training, kernels,
                                  {report, [](const std::string& warning) { spdlog::warn("{}", warning); }}))
      return std::nullopt;
  }
  double mean_loss = 0.0;
  for (const int member : training.members) mean_loss += *members[static_cast<std::size_t>(member)].loss / count;
  return mean_loss;
}

// Disturbance, sensor noise and radii of a whole ensemble, into its folder. Returns whether no signal stopped it.
bool calibrate(const Options& o, const CLI::App& app, const std::string& folder, const ensemble::EnsembleHeader& header,
               const ensemble::TrainingConfig& config, const std::vector<Trajectory>& recordings,
               const nn::Kernels<float>& kernels) {
  const auto base = ensemble::read_given_base(folder, header);
  const auto fitted = config.fit_base ? ensemble::read_base(folder, header) : nullptr;
  std::optional<ensemble::Calibration> found;
  {
    const int networks = ensemble::networks_of_cross_fit(config, recordings.size());
    cli::Progress progress(fmt::format("ens-train: calibration by {} networks", networks), networks, o.common);
    double trained = 0.0;
    found =
        ensemble::cross_fit({recordings, config, base, fitted, header.seed, o.common.jobs, kernels,
                             cli::Interruption::requested, [&] { progress.update(trained += 1.0, "cross-fitting"); }});
  }
  if (!found) return false;
  std::vector<std::string> paths;
  paths.reserve(recordings.size());
  for (const Trajectory& r : recordings) paths.push_back(r.file);
  ensemble::write_calibration(folder, *found, header,
                              cli::provenance(app, o.common, paths, {"--member", "--resume", "--checkpoint-s"}));
  const auto share = [&](const Vec3<double>& part) {
    const Vec3<double> percent = 100.0 * part.cwiseQuotient(found->squared_error);
    return fmt::format("{:.0f}, {:.0f}, {:.0f} %", percent(0), percent(1), percent(2));
  };
  spdlog::info(
      "{}: of the squared errors of {} held-out sequences ({} recordings) in u, v_m, r are expected: by the members' "
      "spread {}, by inputs between samples {}, by disturbances {}, by the sensors {}",
      folder, found->sequences, found->recordings, share(found->of_members), share(found->of_inputs),
      share(found->of_disturbance), share(found->of_sensors));
  return true;
}

// ens-train --calibrate: a folder whose members were trained one by one.
int calibrate_folder(const Options& o, const CLI::App& app) {
  if (!o.output.empty() || !o.base.empty() || o.member >= 0 || o.resume)
    throw UsageError(
        "--calibrate takes a model directory and its training recordings, and no -o, --base, --member or "
        "--resume beside them");
  const ensemble::EnsembleHeader header = *ensemble::read_header(o.calibrate);
  for (int k = 0; k < header.config.members; ++k)
    if (!ensemble::member_exists(o.calibrate, k))
      throw IoError(ensemble::member_path(o.calibrate, k), "is not trained yet; calibration needs all members");
  const std::vector<Trajectory> recordings = read_all(o.recordings, "calibrates with", o);
  const std::vector<ensemble::TrainingFile> files = training_files(recordings);
  const auto is_same = [](const auto& a, const auto& b) {
    return io::stem(a.file) == io::stem(b.file) && a.sha256 == b.sha256;
  };
  if (!std::equal(files.begin(), files.end(), header.files.begin(), header.files.end(), is_same))
    throw UsageError(fmt::format("{}: its members were trained on other recordings than these", o.calibrate));
  ensemble::TrainingConfig config = header.config;
  if (!config.calibration) config.calibration.emplace();
  const cli::Interruption interruption;
  if (calibrate(o, app, o.calibrate, header, config, recordings, nn::kernels(o.kernel))) return cli::kOk;
  spdlog::error("stopped by {}; nothing is written", cli::Interruption::signal_name());
  return cli::kComputationFailed;
}

}  // namespace

int main(int argc, char** argv) try {
  Options o;
  CLI::App app{"Train an ensemble of feedforward networks on trajectories, by maximum likelihood through a rollout.",
               "ens-train"};
  add_options(app, o);
  if (const auto exit_code = cli::parse(app, argc, argv, o.common)) return *exit_code;

  if (!o.status.empty()) {
    if (!o.recordings.empty() || !o.output.empty() || !o.base.empty())
      throw UsageError("--status stands alone: it reads a model directory, and nothing is trained");
    io::write_text("-", cli::training_status_text(o.status, ensemble::read_training_status(o.status)));
    return cli::kOk;
  }
  if (o.recordings.empty()) throw UsageError("recordings is required");
  if (!o.calibrate.empty()) return calibrate_folder(o, app);
  if (o.output.empty()) throw UsageError("--output is required");
  if (o.output == "-") throw UsageError("--output: a model directory cannot be '-'");

  ensemble::TrainingConfig config = ensemble::read_training_config(o.config);
  if (o.members > 0) config.members = o.members;
  if (o.epochs > 0) config.epochs = o.epochs;
  if (o.no_initial_state_net) config.initial_state_net = false;
  take_base_spread(o, config);
  if (o.epochs > 0 || o.no_initial_state_net || !o.base.empty())
    config.follows.clear();  // no longer what the config says it is
  if (o.member >= config.members)
    throw UsageError(fmt::format("--member {}: expected 0 to {}, one of the {} members", o.member, config.members - 1,
                                 config.members));
  const nn::Kernels<float>& kernels = nn::kernels(o.kernel);
  check_outputs(o);
  ensemble::require_room(o.output, config);
  const auto base = o.base.empty() ? nullptr : ensemble::BaseModel::read(o.base);

  const std::vector<Trajectory> recordings = read_all(o.recordings, "trains on", o);
  ensemble::require_recordings_to_hold_out(config, recordings);
  const std::vector<ensemble::TrainingFile> files = training_files(recordings);
  const ensemble::TrainingData data = prepare(o, recordings, config, base, files);
  std::optional<ensemble::TrainingData> held_out;
  if (!o.held_out.empty()) {
    held_out = ensemble::prepare_held_out_data(read_all(o.held_out, "holds out", o), data);
    cli::warn_all(held_out->notices);
  }
  io::make_directories(o.output);
  const ensemble::TrainingLock lock(o.output);
  const ensemble::EnsembleHeader header = open_folder(o, app, data, recordings, files, lock);

  const cli::Interruption interruption;
  ensemble::EnsembleTraining training{o.output,
                                      {},
                                      o.resume,
                                      o.checkpoint_s,
                                      o.common.jobs,
                                      held_out ? &*held_out : nullptr,
                                      cli::Interruption::requested};
  training.members.resize(o.member >= 0 ? 1 : static_cast<std::size_t>(config.members), std::max(0, o.member));
  if (o.member < 0) std::iota(training.members.begin(), training.members.end(), 0);

  const std::optional<double> mean_loss = train(o, data, header, training, kernels);
  if (!mean_loss) {
    spdlog::error("stopped by {}; checkpoints are written. The same command with --resume continues from there",
                  cli::Interruption::signal_name());
    return cli::kComputationFailed;
  }
  spdlog::info("{}: {} member{} trained on {} windows, mean loss {:.4g} (noise alone gives 3)", o.output,
               training.members.size(), training.members.size() == 1 ? "" : "s", data.windows.size(), *mean_loss);
  if (o.member < 0 && config.calibration && !ensemble::read_calibration(o.output, header) &&
      !calibrate(o, app, o.output, header, config, recordings, kernels)) {
    spdlog::error("stopped by {} in the calibration. The same command with --resume begins it again",
                  cli::Interruption::signal_name());
    return cli::kComputationFailed;
  }
  return cli::kOk;
} catch (...) {
  return cli::report_current_exception("ens-train");
}
