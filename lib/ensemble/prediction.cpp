#include "ensemble/prediction.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "core/errors.hpp"

namespace leeway::ensemble {
namespace {

constexpr double kBoundsFactor = 10.0;  // of the training data's range

// States of several sequences side by side, for one member.
class Columns {
 public:
  Columns(EnsembleEvaluator& evaluator, int member, Integrator integrator, std::size_t actuators)
      : evaluator_(evaluator),
        member_(member),
        integrator_(integrator),
        channels_(static_cast<Eigen::Index>(actuators)) {}

  void resize(std::size_t count) {
    const auto n = static_cast<Eigen::Index>(count);
    eta.conservativeResize(3, n);
    nu.conservativeResize(3, n);
    actuators_.resize(channels_, n);
    true_wind_.resize(2, n);
    t_s_.resize(n);
  }

  // Column i is moved by what the recording of the task holds at its point k.
  void hold(Eigen::Index i, const SequenceTask& task, Eigen::Index k) {
    const Samples& samples = *task.samples;
    const Eigen::Index at = task.range.begin + k;
    actuators_.col(i) = samples.actuators.col(at);
    true_wind_.col(i) = samples.true_wind.col(at);
    t_s_(i) = samples.t_s(at);
  }

  void step(double dt_s) { evaluator_.step(member_, integrator_, dt_s, actuators_, true_wind_, eta, nu, t_s_); }

  Eigen::Matrix3Xd eta, nu;

 private:
  EnsembleEvaluator& evaluator_;
  int member_;
  Integrator integrator_;
  Eigen::Index channels_;
  Eigen::MatrixXd actuators_;
  Eigen::Matrix2Xd true_wind_;
  Eigen::RowVectorXd t_s_;
};

// The particles of one sequence on their way.
class Particles {
 public:
  Particles(const SequenceTask& task, const Ensemble& ensemble, const PredictionOptions& options)
      : task_(&task),
        members_(static_cast<std::size_t>(ensemble.members())),
        random_(options.seed, "members of particles of " + task.samples->recording, task.sequence),
        particles_(static_cast<std::size_t>(options.particles)) {
    prediction.eta.emplace_back(task.samples->eta.col(task.range.begin));
    prediction.nu.emplace_back(task.samples->nu.col(task.range.begin));
    prediction.state.emplace_back(particles_, 0);
    draw();
    prediction.member.push_back(member_);
  }

  const SequenceTask& task() const { return *task_; }
  Eigen::Index steps() const { return task_->range.size - 1; }

  // Each particle draws the member that moves it from now on.
  void draw() { member_ = shared_out(particles_, members_, random_); }

  // Makes room for the next point. Particles that share state and member are one column of it, sorted by member;
  // returns these pairs (member, state).
  const std::vector<std::pair<int, int>>& begin_step() {
    const std::vector<int>& state = prediction.state.back();
    std::vector<std::pair<int, int>> pairs(particles_);
    for (std::size_t p = 0; p < particles_; ++p) pairs[p] = {member_[p], state[p]};
    distinct_ = pairs;
    std::sort(distinct_.begin(), distinct_.end());
    distinct_.erase(std::unique(distinct_.begin(), distinct_.end()), distinct_.end());
    std::vector<int> next(particles_);
    for (std::size_t p = 0; p < particles_; ++p)
      next[p] = static_cast<int>(std::lower_bound(distinct_.begin(), distinct_.end(), pairs[p]) - distinct_.begin());
    prediction.state.push_back(std::move(next));
    prediction.member.push_back(member_);
    const auto n = static_cast<Eigen::Index>(distinct_.size());
    prediction.eta.emplace_back(3, n);
    prediction.nu.emplace_back(3, n);
    return distinct_;
  }

  // Looks for states that are none, and for particles far out.
  void judge(const ModelInputs& inputs) {
    std::vector<bool> left(particles_, false);
    for (std::size_t k = 1; k < prediction.eta.size(); ++k) {
      const double time_s = task_->samples->t_s(task_->range.begin + static_cast<Eigen::Index>(k));
      const Eigen::Matrix3Xd& nu = prediction.nu[k];
      if (!prediction.eta[k].allFinite() || !nu.allFinite())
        throw NumericalError(fmt::format("{}: sequence {}: a particle is no finite number at t = {} s",
                                         task_->samples->recording, task_->sequence, time_s));
      for (std::size_t p = 0; p < particles_; ++p) {
        const auto v = nu.col(prediction.state[k][p]);
        const bool out = std::max(std::abs(v(0)), std::abs(v(1))) > kBoundsFactor * inputs.largest_speed_mps ||
                         std::abs(v(2)) > kBoundsFactor * inputs.largest_rate_radps;
        if (!out || left[p]) continue;
        left[p] = true;
        if (prediction.out_of_bounds++ == 0) prediction.first_out_of_bounds_s = time_s;
      }
    }
  }

  SequencePrediction prediction;

 private:
  const SequenceTask* task_;
  std::size_t members_;
  RandomStream random_;
  std::size_t particles_;
  std::vector<int> member_;
  std::vector<std::pair<int, int>> distinct_;
};

// TS-infinity: a member's trajectories through all sequences, from begin to end.
void propagate_member(Columns& columns, int member, std::vector<Particles>& sequences,
                      const std::vector<std::vector<std::pair<int, int>>>& first) {
  struct Lane {
    std::size_t sequence;
    Eigen::Index column;
  };
  std::vector<Lane> lanes;
  for (std::size_t s = 0; s < sequences.size(); ++s)
    for (std::size_t i = 0; i < first[s].size(); ++i)
      if (first[s][i].first == member) lanes.push_back({s, static_cast<Eigen::Index>(i)});
  // The longest first: those on the way are always the first ones.
  std::stable_sort(lanes.begin(), lanes.end(), [&](const Lane& a, const Lane& b) {
    return sequences[a.sequence].steps() > sequences[b.sequence].steps();
  });
  columns.resize(lanes.size());
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const SequencePrediction& prediction = sequences[lanes[i].sequence].prediction;
    columns.eta.col(static_cast<Eigen::Index>(i)) = prediction.eta.front().col(0);
    columns.nu.col(static_cast<Eigen::Index>(i)) = prediction.nu.front().col(0);
  }
  for (Eigen::Index k = 0;; ++k) {
    while (!lanes.empty() && sequences[lanes.back().sequence].steps() <= k) lanes.pop_back();
    if (lanes.empty()) return;
    columns.resize(lanes.size());
    for (std::size_t i = 0; i < lanes.size(); ++i)
      columns.hold(static_cast<Eigen::Index>(i), sequences[lanes[i].sequence].task(), k);
    columns.step(sequences[lanes.front().sequence].task().samples->dt_s);
    for (std::size_t i = 0; i < lanes.size(); ++i) {
      SequencePrediction& prediction = sequences[lanes[i].sequence].prediction;
      const auto point = static_cast<std::size_t>(k + 1);
      prediction.eta[point].col(lanes[i].column) = columns.eta.col(static_cast<Eigen::Index>(i));
      prediction.nu[point].col(lanes[i].column) = columns.nu.col(static_cast<Eigen::Index>(i));
    }
  }
}

// TS1: step k of all sequences that reach it, by the members that were drawn.
void propagate_step(std::vector<Columns>& columns, std::vector<Particles>& sequences, Eigen::Index k) {
  struct Lane {
    Particles* particles;
    Eigen::Index state, column;
  };
  std::vector<std::vector<Lane>> lanes(columns.size());
  for (Particles& particles : sequences) {
    if (k >= particles.steps()) continue;
    if (k > 0) particles.draw();
    Eigen::Index column = 0;
    for (const auto& [member, state] : particles.begin_step())
      lanes[static_cast<std::size_t>(member)].push_back({&particles, state, column++});
  }
  const auto point = static_cast<std::size_t>(k);
  for (std::size_t m = 0; m < columns.size(); ++m) {
    if (lanes[m].empty()) continue;
    columns[m].resize(lanes[m].size());
    for (std::size_t i = 0; i < lanes[m].size(); ++i) {
      const auto [particles, state, column] = lanes[m][i];
      const auto at = static_cast<Eigen::Index>(i);
      columns[m].eta.col(at) = particles->prediction.eta[point].col(state);
      columns[m].nu.col(at) = particles->prediction.nu[point].col(state);
      columns[m].hold(at, particles->task(), k);
    }
    columns[m].step(lanes[m].front().particles->task().samples->dt_s);
    for (std::size_t i = 0; i < lanes[m].size(); ++i) {
      const auto [particles, state, column] = lanes[m][i];
      particles->prediction.eta[point + 1].col(column) = columns[m].eta.col(static_cast<Eigen::Index>(i));
      particles->prediction.nu[point + 1].col(column) = columns[m].nu.col(static_cast<Eigen::Index>(i));
    }
  }
}

}  // namespace

std::vector<int> shared_out(std::size_t particles, std::size_t members, RandomStream& random) {
  std::vector<int> order(members);
  std::iota(order.begin(), order.end(), 0);
  random.shuffle(order);  // who gets one more
  std::vector<int> member(particles);
  for (std::size_t p = 0; p < particles; ++p) member[p] = order[p % members];
  random.shuffle(member);
  return member;
}

std::vector<SequencePrediction> predict_sequences(EnsembleEvaluator& evaluator, const Ensemble& ensemble,
                                                  std::span<const SequenceTask> tasks,
                                                  const PredictionOptions& options) {
  const ModelInputs& inputs = ensemble.header().inputs;
  std::vector<Particles> sequences;
  Eigen::Index longest = 0;
  for (const SequenceTask& task : tasks) {
    sequences.emplace_back(task, ensemble, options);
    longest = std::max(longest, task.range.size);
  }
  std::vector<Columns> columns;
  for (int m = 0; m < ensemble.members(); ++m)
    columns.emplace_back(evaluator, m, options.integrator, inputs.sampled_actuators().size());

  if (options.sampling == Sampling::ts1) {
    for (Eigen::Index k = 0; k + 1 < longest; ++k) propagate_step(columns, sequences, k);
  } else {
    // The columns of the first step are those of all others.
    std::vector<std::vector<std::pair<int, int>>> first(sequences.size());
    for (std::size_t s = 0; s < sequences.size(); ++s)
      for (Eigen::Index k = 0; k < sequences[s].steps(); ++k) {
        const std::vector<std::pair<int, int>>& pairs = sequences[s].begin_step();
        if (k == 0) first[s] = pairs;
      }
    for (int m = 0; m < ensemble.members(); ++m)
      propagate_member(columns[static_cast<std::size_t>(m)], m, sequences, first);
  }
  std::vector<SequencePrediction> predictions;
  for (Particles& particles : sequences) {
    particles.judge(inputs);
    predictions.push_back(std::move(particles.prediction));
  }
  return predictions;
}

SequencePrediction predict_sequence(EnsembleEvaluator& evaluator, const Ensemble& ensemble, const Samples& samples,
                                    Range range, std::size_t sequence, const PredictionOptions& options) {
  const SequenceTask task{&samples, range, sequence};
  return std::move(predict_sequences(evaluator, ensemble, {&task, 1}, options).front());
}

SequencePrediction fitted_rollout(EnsembleEvaluator& evaluator, const Ensemble& ensemble, const Samples& samples,
                                  Range range) {
  SequencePrediction result;
  std::vector<int> number(static_cast<std::size_t>(ensemble.members()));
  Eigen::Matrix3Xd eta(3, ensemble.members()), nu(3, ensemble.members());
  for (int m = 0; m < ensemble.members(); ++m) {
    number[static_cast<std::size_t>(m)] = m;
    Vec3<double> e, v;
    evaluator.estimate_initial_state(m, samples, range, e, v);
    eta.col(m) = e;
    nu.col(m) = v;
  }
  for (Eigen::Index k = 0; k < range.size; ++k) {
    result.eta.push_back(eta);
    result.nu.push_back(nu);
    result.state.push_back(number);
    result.member.push_back(number);
    if (k + 1 == range.size) break;
    for (int m = 0; m < ensemble.members(); ++m) {
      Eigen::Matrix3Xd e = eta.col(m), v = nu.col(m);
      evaluator.step(m, Integrator::euler, samples.dt_s, samples.actuators.col(range.begin + k),
                     samples.true_wind.col(range.begin + k), e, v,
                     Eigen::RowVectorXd::Constant(1, samples.t_s(range.begin + k)));
      eta.col(m) = e;
      nu.col(m) = v;
    }
    if (!eta.allFinite() || !nu.allFinite())
      throw NumericalError(fmt::format("{}: the fitted rollout is no finite number at t = {} s", samples.recording,
                                       samples.t_s(range.begin + k + 1)));
  }
  return result;
}

SequencePrediction hold_velocity(const Samples& samples, Range range) {
  SequencePrediction result;
  Eigen::Matrix3Xd eta = samples.eta.col(range.begin);
  const Eigen::Matrix3Xd nu = samples.nu.col(range.begin);
  const double dt = samples.dt_s;
  for (Eigen::Index k = 0; k < range.size; ++k) {
    result.eta.push_back(eta);
    result.nu.push_back(nu);
    result.state.push_back({0});
    result.member.push_back({0});
    // Constant (u, v_m, r) is motion on a circle; Simpson's rule over the turning heading is exact to (r dt)^4.
    Eigen::Matrix3Xd middle = eta, end = eta;
    middle.row(2) += 0.5 * dt * nu.row(2);
    end.row(2) += dt * nu.row(2);
    eta += dt / 6.0 * (pose_rates(eta, nu) + 4.0 * pose_rates(middle, nu) + pose_rates(end, nu));
  }
  return result;
}

}  // namespace leeway::ensemble
