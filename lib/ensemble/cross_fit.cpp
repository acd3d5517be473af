#include "ensemble/cross_fit.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <mutex>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "ensemble/base_preparation.hpp"
#include "ensemble/error_growth.hpp"
#include "ensemble/prediction.hpp"
#include "ensemble/prediction_run.hpp"

namespace leeway::ensemble {
namespace {

constexpr double kLeastShare = 1e-3;  // of an axis' disturbance, below which a process is left out, our choice

// A held-out sequence: what is missed at each point but the first, and what is expected of it.
struct HeldOut {
  std::string recording;
  std::vector<Vec3<double>> error;     // recorded - mean of the networks, (u, v_m [m/s], r [rad/s])
  std::vector<double> position_error;  // [m]; NaN without positions
  MissedBlocks blocks;
};

// Networks that have not seen the recordings of their fold.
struct Fold {
  std::vector<Trajectory> held_out, others;
  TrainingData data;
  std::vector<Member> members;
  std::vector<std::shared_ptr<const BaseModel>> bases;
};

// Dealt in a drawn order; equal numbers of recordings, or one more.
std::vector<Fold> deal(const CrossFitting& fitting) {
  const std::size_t n = fitting.recordings.size();
  std::vector<std::size_t> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = i;
  RandomStream random(fitting.seed, "folds");
  random.shuffle(order);
  const std::size_t count = std::min(n, static_cast<std::size_t>(fitting.config.calibration->folds));
  std::vector<std::size_t> fold_of(n);
  for (std::size_t i = 0; i < n; ++i) fold_of[order[i]] = i % count;
  std::vector<Fold> folds(count);
  for (std::size_t f = 0; f < count; ++f)
    for (std::size_t i = 0; i < n; ++i)
      (fold_of[i] == f ? folds[f].held_out : folds[f].others).push_back(fitting.recordings[i]);
  return folds;
}

// A step of all networks, and the derivatives of their mean.
//   eta, nu  of each network, moved on
StepDerivatives step_all(EnsembleEvaluator& evaluator, const Ensemble& ensemble, const Samples& samples, Eigen::Index k,
                         Eigen::Matrix3Xd& eta, Eigen::Matrix3Xd& nu) {
  const TrainingConfig& config = ensemble.header().config;
  const Eigen::Index channels = samples.actuators.rows(), inputs = channels + 2;
  StepDerivatives result;
  result.by_input = Eigen::Matrix4Xd::Zero(4, inputs);
  // Differences of a standard deviation of the sensors, and of half of what is open: networks compute in single
  // precision.
  const Eigen::Vector4d h(config.pose_scale(2), config.sigma(0), config.sigma(1), config.sigma(2));
  for (int m = 0; m < ensemble.members(); ++m) {
    const Eigen::Index n = 1 + 2 * (4 + inputs);
    Eigen::Matrix3Xd e = eta.col(m).replicate(1, n), v = nu.col(m).replicate(1, n);
    Eigen::MatrixXd actuators = samples.actuators.col(k).replicate(1, n);
    Eigen::Matrix2Xd wind = samples.true_wind.col(k).replicate(1, n);
    for (const int side : {0, 1}) {
      const double sign = side == 0 ? 1.0 : -1.0;
      const auto column = [&](Eigen::Index i) { return 1 + 2 * i + side; };
      e(2, column(0)) += sign * h(0);
      for (Eigen::Index j = 0; j < 3; ++j) v(j, column(1 + j)) += sign * h(1 + j);
      for (Eigen::Index a = 0; a < channels; ++a)
        actuators(a, column(4 + a)) += sign * 0.5 * samples.actuators_open(a, k);
      for (Eigen::Index w = 0; w < 2; ++w)
        wind(w, column(4 + channels + w)) += sign * 0.5 * samples.true_wind_open(w, k);
    }
    evaluator.step(m, config.integrator_predict, samples.dt_s, actuators, wind, e, v,
                   Eigen::RowVectorXd::Constant(1, samples.t_s(k)));
    const auto difference = [&](Eigen::Index i) {
      Eigen::Vector4d d;
      d << e(2, 1 + 2 * i) - e(2, 2 + 2 * i), v.col(1 + 2 * i) - v.col(2 + 2 * i);
      return Eigen::Vector4d(d / ensemble.members());
    };
    for (Eigen::Index j = 0; j < 4; ++j) result.by_state.col(j) += difference(j) / (2.0 * h(j));
    for (Eigen::Index a = 0; a < inputs; ++a) result.by_input.col(a) += difference(4 + a);
    eta.col(m) = e.col(0);
    nu.col(m) = v.col(0);
  }
  return result;
}

HeldOut predict_held_out(EnsembleEvaluator& evaluator, const Ensemble& ensemble, const SequenceTask& task,
                         const Noises& noises) {
  const Samples& samples = *task.samples;
  HeldOut result{samples.recording, {}, {}, {}};
  Eigen::Matrix3Xd eta = samples.eta.col(task.range.begin).replicate(1, ensemble.members());
  Eigen::Matrix3Xd nu = samples.nu.col(task.range.begin).replicate(1, ensemble.members());
  std::vector<StepDerivatives> steps;
  std::vector<Eigen::Matrix3Xd> networks;
  for (Eigen::Index at = task.range.begin + 1; at < task.range.begin + task.range.size; ++at) {
    steps.push_back(step_all(evaluator, ensemble, samples, at - 1, eta, nu));
    if (!eta.allFinite() || !nu.allFinite())
      throw NumericalError(
          fmt::format("{}: a held-out prediction is no finite number at t = {} s", samples.recording, samples.t_s(at)));
    networks.push_back(nu);
    result.error.emplace_back(samples.nu.col(at) - nu.rowwise().mean());
    const Vec3<double> pose = eta.rowwise().mean();
    result.position_error.push_back(samples.has_position ? (samples.eta.col(at) - pose).head<2>().norm() : NAN);
  }
  result.blocks = missed_blocks(result.error, networks, steps, noises);
  return result;
}

std::vector<HeldOut> predict_fold(const CrossFitting& fitting, Fold& fold, const Noises& noises) {
  const Ensemble ensemble(make_header(fold.data, fitting.seed, {}), std::move(fold.members), fitting.kernels,
                          fold.data.base, std::move(fold.bases));
  EnsembleEvaluator evaluator(ensemble);
  const TrainingConfig& config = fitting.config;
  const ModelInputs& inputs = fold.data.inputs;
  if (fold.data.base) fold.data.base->prepare(fold.held_out);
  std::vector<HeldOut> result;
  for (const Trajectory& recording : fold.held_out) {
    const std::vector<Samples> stretches = resample(recording, inputs.sampled_actuators(), inputs.wind,
                                                    config.time_step_s, config.resampling, config.inputs);
    for (const SequenceTask& task : sequences_of(stretches, config.steps, false))
      result.push_back(predict_held_out(evaluator, ensemble, task, noises));
  }
  return result;
}

// The k-th smallest, k = ceil((n + 1) share).
std::optional<double> radius(std::vector<double> scores, double share) {
  const auto k = static_cast<std::size_t>(std::ceil(static_cast<double>(scores.size() + 1) * share - 1e-9));
  if (k > scores.size() || std::ranges::any_of(scores, [](double x) { return std::isnan(x); })) return std::nullopt;
  std::ranges::nth_element(scores, scores.begin() + static_cast<std::ptrdiff_t>(k - 1));
  return scores[k - 1];
}

std::vector<RadiiAtTime> radii_of(const std::vector<HeldOut>& all, double dt_s, std::size_t& recordings) {
  std::vector<std::string> names;
  for (const HeldOut& sequence : all)
    if (std::ranges::find(names, sequence.recording) == names.end()) names.push_back(sequence.recording);
  recordings = names.size();
  std::vector<RadiiAtTime> result;
  for (std::size_t k = 0; k < all.front().error.size(); ++k) {
    std::array<std::vector<double>, 4> scores;
    for (const std::string& name : names) {
      std::array<double, 4> largest{};
      for (const HeldOut& sequence : all) {
        if (sequence.recording != name) continue;
        for (std::size_t c = 0; c < 3; ++c)
          largest[c] = std::max(largest[c], std::abs(sequence.error[k](static_cast<Eigen::Index>(c))));
        if (!(sequence.position_error[k] <= largest[3])) largest[3] = sequence.position_error[k];
      }
      for (std::size_t c = 0; c < 4; ++c) scores[c].push_back(largest[c]);
    }
    RadiiAtTime at{static_cast<double>(k + 1) * dt_s, {}};
    for (std::size_t c = 0; c < 4; ++c) at.channels[c] = {radius(scores[c], 0.5), radius(scores[c], 0.9)};
    result.push_back(at);
  }
  return result;
}

Calibration calibration_of(const std::vector<HeldOut>& all, const Noises& noises, const TrainingConfig& config) {
  Calibration result;
  result.members = config.calibration->members;
  result.sequences = all.size();
  result.radii = radii_of(all, config.time_step_s, result.recordings);
  std::vector<MissedBlocks> blocks;
  blocks.reserve(all.size());
  for (const HeldOut& sequence : all) blocks.push_back(sequence.blocks);
  const std::vector<double> v = noise_variances(blocks, noises);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    result.sensor_sd(static_cast<Eigen::Index>(axis)) = std::sqrt(v[noises.sensor(axis)]);
    double total = 0.0;
    for (std::size_t i = 0; i < noises.tau_s.size(); ++i) total += v[noises.disturbance(axis, i)] * noises.tau_s[i];
    for (std::size_t i = 0; i < noises.tau_s.size(); ++i)
      if (const double of_process = v[noises.disturbance(axis, i)]; of_process * noises.tau_s[i] > kLeastShare * total)
        result.disturbance.axes[axis].push_back({std::sqrt(of_process), noises.tau_s[i]});
  }
  // Means over blocks and sequences.
  double count = 0.0;
  const auto add = [](const Eigen::VectorXd& values, Vec3<double>& sum) {
    for (Eigen::Index i = 0; i < values.size(); ++i) sum(i % 3) += values(i);
  };
  for (const MissedBlocks& sequence : blocks) {
    count += static_cast<double>(sequence.missed.size()) / 3.0;
    add(sequence.missed.cwiseAbs2(), result.squared_error);
    add(sequence.of_members.diagonal(), result.of_members);
    add(sequence.of_inputs.diagonal(), result.of_inputs);
    for (std::size_t c = 0; c < v.size(); ++c)
      add(v[c] * sequence.by_unit[c].diagonal(), c < noises.sensor(0) ? result.of_disturbance : result.of_sensors);
  }
  for (Vec3<double>* sum :
       {&result.squared_error, &result.of_members, &result.of_inputs, &result.of_disturbance, &result.of_sensors})
    *sum /= count;
  return result;
}

}  // namespace

int networks_of_cross_fit(const TrainingConfig& config, std::size_t recordings) {
  if (!config.calibration || recordings < 2) return 0;
  return config.calibration->members *
         static_cast<int>(std::min(recordings, static_cast<std::size_t>(config.calibration->folds)));
}

void require_recordings_to_hold_out(const TrainingConfig& config, const std::vector<Trajectory>& recordings) {
  if (config.calibration && recordings.size() < 2)
    throw InputError(recordings.empty() ? "" : recordings.front().file,
                     fmt::format("the calibration that the config asks for holds recordings out in turn: expected at "
                                 "least two, got {}; a config without 'calibration' trains on one",
                                 recordings.size()));
}

std::optional<Calibration> cross_fit(const CrossFitting& fitting) {
  require_recordings_to_hold_out(fitting.config, fitting.recordings);
  std::vector<Fold> folds = deal(fitting);
  parallel_for(folds.size(), fitting.jobs, [&](std::size_t f) {
    std::optional<BaseSpreadEstimate> found;
    folds[f].data = prepare_on_base(folds[f].others, fitting.config, fitting.base, found, 1, fitting.fitted.get());
    folds[f].members.resize(static_cast<std::size_t>(fitting.config.calibration->members));
    folds[f].bases.resize(folds[f].members.size());
  });
  const std::size_t per_fold = folds.front().members.size();
  std::mutex mutex;
  std::atomic<bool> stopped{false};
  parallel_for(folds.size() * per_fold, fitting.jobs, [&](std::size_t i) {
    Fold& fold = folds[i / per_fold];
    const std::size_t number = i % per_fold;
    const TrainingData own = data_of_member(fold.data, fitting.seed, static_cast<int>(number));
    if (own.has_drawn_base) fold.bases[number] = own.base;
    TrainingState state = initial_training_state(own, fitting.seed, static_cast<int>(number), fitting.kernels);
    const auto go_on = [&](const TrainingState&) { return !(fitting.stop && fitting.stop()); };
    if (stopped || !train(own, fitting.seed, fitting.kernels, state, go_on)) {
      stopped = true;
      return;
    }
    fold.members[number] = std::move(state.member);
    const std::lock_guard lock(mutex);
    if (fitting.progress) fitting.progress();
  });
  if (stopped) return std::nullopt;
  const Noises noises(fitting.config.time_step_s, fitting.config.steps);
  std::vector<std::vector<HeldOut>> by_fold(folds.size());
  parallel_for(folds.size(), fitting.jobs,
               [&](std::size_t f) { by_fold[f] = predict_fold(fitting, folds[f], noises); });
  std::vector<HeldOut> all;
  for (std::vector<HeldOut>& sequences : by_fold) std::ranges::move(sequences, std::back_inserter(all));
  if (all.empty())
    throw InputError(fitting.recordings.front().file,
                     fmt::format("calibration needs recordings that hold a sequence of {} points {} s apart",
                                 fitting.config.steps, fitting.config.time_step_s));
  Calibration result = calibration_of(all, noises, fitting.config);
  result.folds = static_cast<int>(folds.size());
  return result;
}

}  // namespace leeway::ensemble
