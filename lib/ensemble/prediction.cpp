#include "ensemble/prediction.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

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
  //   open  shares of what is open of the inputs that come on top; empty: none
  void hold(Eigen::Index i, const SequenceTask& task, Eigen::Index k, const Eigen::VectorXd& open) {
    const Samples& samples = *task.samples;
    const Eigen::Index at = task.range.begin + k;
    actuators_.col(i) = samples.actuators.col(at);
    true_wind_.col(i) = samples.true_wind.col(at);
    if (open.size() > 0) {
      actuators_.col(i) += samples.actuators_open.col(at).cwiseProduct(open.head(channels_));
      true_wind_.col(i) += samples.true_wind_open.col(at).cwiseProduct(open.tail<2>());
    }
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

// A column of states on its way: the member that moves it, its state's column at the point before, and the particle
// whose disturbance it has.
struct ParticleColumn {
  static constexpr int kShared = -1;  // by particles without one
  int member, state, particle;

  friend bool operator<(const ParticleColumn& a, const ParticleColumn& b) {
    return std::tie(a.member, a.state, a.particle) < std::tie(b.member, b.state, b.particle);
  }
  friend bool operator==(const ParticleColumn&, const ParticleColumn&) = default;
};

// The particles of one sequence on their way.
class Particles {
 public:
  Particles(const SequenceTask& task, const Ensemble& ensemble, const PredictionOptions& options)
      : task_(&task),
        members_(static_cast<std::size_t>(ensemble.members())),
        random_(options.seed, "members of particles of " + task.samples->recording, task.sequence),
        particles_(static_cast<std::size_t>(options.particles)),
        each_alone_(options.particles_differ()) {
    prediction.eta.emplace_back(task.samples->eta.col(task.range.begin));
    prediction.nu.emplace_back(task.samples->nu.col(task.range.begin));
    prediction.state.emplace_back(particles_, 0);
    if (each_alone_) draw_noise(options);
    draw();
    prediction.member.push_back(member_);
  }

  const SequenceTask& task() const { return *task_; }
  Eigen::Index steps() const { return task_->range.size - 1; }

  // Each particle draws the member that moves it from now on.
  void draw() { member_ = shared_out(particles_, members_, random_); }

  // Makes room for the next point. Particles that share state and member are one column of it, sorted by member, unless
  // each has its own disturbance.
  const std::vector<ParticleColumn>& begin_step() {
    const std::vector<int>& state = prediction.state.back();
    std::vector<ParticleColumn> columns(particles_);
    for (std::size_t p = 0; p < particles_; ++p)
      columns[p] = {member_[p], state[p], each_alone_ ? static_cast<int>(p) : ParticleColumn::kShared};
    distinct_ = columns;
    std::sort(distinct_.begin(), distinct_.end());
    distinct_.erase(std::unique(distinct_.begin(), distinct_.end()), distinct_.end());
    std::vector<int> next(particles_);
    for (std::size_t p = 0; p < particles_; ++p)
      next[p] = static_cast<int>(std::lower_bound(distinct_.begin(), distinct_.end(), columns[p]) - distinct_.begin());
    prediction.state.push_back(std::move(next));
    prediction.member.push_back(member_);
    const auto n = static_cast<Eigen::Index>(distinct_.size());
    prediction.eta.emplace_back(3, n);
    prediction.nu.emplace_back(3, n);
    return distinct_;
  }

  // What a column's disturbance adds to (u, v_m, r) over the step from point k.
  Vec3<double> disturbed(const ParticleColumn& column, Eigen::Index k) const {
    if (!each_alone_) return Vec3<double>::Zero();
    return task_->samples->dt_s * disturbance_[static_cast<std::size_t>(k)].col(column.particle);
  }

  // Its shares of what is open of the inputs; none where there are no draws.
  Eigen::VectorXd open_inputs(const ParticleColumn& column) const {
    if (open_inputs_.size() == 0) return {};
    return open_inputs_.col(column.particle);
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
  // A path of the disturbance and an initial velocity for each particle.
  void draw_noise(const PredictionOptions& options) {
    const Samples& samples = *task_->samples;
    RandomStream random(options.seed, "disturbance of particles of " + samples.recording, task_->sequence);
    const auto n = static_cast<Eigen::Index>(particles_);
    if (options.draws_inputs) open_inputs_.resize(samples.actuators.rows() + 2, n);
    disturbance_.assign(static_cast<std::size_t>(steps()), Eigen::Matrix3Xd(3, n));
    prediction.eta.front() = prediction.eta.front().replicate(1, n).eval();
    prediction.nu.front() = prediction.nu.front().replicate(1, n).eval();
    for (Eigen::Index p = 0; p < n; ++p) {
      for (int i = 0; i < 3; ++i) prediction.nu.front()(i, p) += options.initial_sd(i) * random.normal();
      prediction.state.front()[static_cast<std::size_t>(p)] = static_cast<int>(p);
      DisturbancePath path(options.disturbance, samples.dt_s, random);
      for (Eigen::Matrix3Xd& at : disturbance_) at.col(p) = path.next(random);
      if (options.draws_inputs)
        for (double& x : open_inputs_.col(p)) x = random.uniform(-0.5, 0.5);
    }
  }

  const SequenceTask* task_;
  std::size_t members_;
  RandomStream random_;
  std::size_t particles_;
  bool each_alone_;
  std::vector<int> member_;
  std::vector<ParticleColumn> distinct_;
  std::vector<Eigen::Matrix3Xd> disturbance_;  // accelerations of each step; empty where there is none
  Eigen::MatrixXd open_inputs_;                // shares of what is open, a column for each particle
};

// TS-infinity: a member's trajectories through all sequences, from begin to end.
void propagate_member(Columns& columns, int member, std::vector<Particles>& sequences,
                      const std::vector<std::vector<ParticleColumn>>& first) {
  struct Lane {
    std::size_t sequence;
    Eigen::Index column;
    ParticleColumn of;
  };
  std::vector<Lane> lanes;
  for (std::size_t s = 0; s < sequences.size(); ++s)
    for (std::size_t i = 0; i < first[s].size(); ++i)
      if (first[s][i].member == member) lanes.push_back({s, static_cast<Eigen::Index>(i), first[s][i]});
  // The longest first: those on the way are always the first ones.
  std::stable_sort(lanes.begin(), lanes.end(), [&](const Lane& a, const Lane& b) {
    return sequences[a.sequence].steps() > sequences[b.sequence].steps();
  });
  columns.resize(lanes.size());
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const SequencePrediction& prediction = sequences[lanes[i].sequence].prediction;
    columns.eta.col(static_cast<Eigen::Index>(i)) = prediction.eta.front().col(lanes[i].of.state);
    columns.nu.col(static_cast<Eigen::Index>(i)) = prediction.nu.front().col(lanes[i].of.state);
  }
  for (Eigen::Index k = 0;; ++k) {
    while (!lanes.empty() && sequences[lanes.back().sequence].steps() <= k) lanes.pop_back();
    if (lanes.empty()) return;
    columns.resize(lanes.size());
    for (std::size_t i = 0; i < lanes.size(); ++i)
      columns.hold(static_cast<Eigen::Index>(i), sequences[lanes[i].sequence].task(), k,
                   sequences[lanes[i].sequence].open_inputs(lanes[i].of));
    columns.step(sequences[lanes.front().sequence].task().samples->dt_s);
    for (std::size_t i = 0; i < lanes.size(); ++i) {
      SequencePrediction& prediction = sequences[lanes[i].sequence].prediction;
      const auto point = static_cast<std::size_t>(k + 1);
      columns.nu.col(static_cast<Eigen::Index>(i)) += sequences[lanes[i].sequence].disturbed(lanes[i].of, k);
      prediction.eta[point].col(lanes[i].column) = columns.eta.col(static_cast<Eigen::Index>(i));
      prediction.nu[point].col(lanes[i].column) = columns.nu.col(static_cast<Eigen::Index>(i));
    }
  }
}

// TS1: step k of all sequences that reach it, by the members that were drawn.
void propagate_step(std::vector<Columns>& columns, std::vector<Particles>& sequences, Eigen::Index k) {
  struct Lane {
    Particles* particles;
    ParticleColumn of;
    Eigen::Index column;
  };
  std::vector<std::vector<Lane>> lanes(columns.size());
  for (Particles& particles : sequences) {
    if (k >= particles.steps()) continue;
    if (k > 0) particles.draw();
    Eigen::Index column = 0;
    for (const ParticleColumn& of : particles.begin_step())
      lanes[static_cast<std::size_t>(of.member)].push_back({&particles, of, column++});
  }
  const auto point = static_cast<std::size_t>(k);
  for (std::size_t m = 0; m < columns.size(); ++m) {
    if (lanes[m].empty()) continue;
    columns[m].resize(lanes[m].size());
    for (std::size_t i = 0; i < lanes[m].size(); ++i) {
      const auto& [particles, of, column] = lanes[m][i];
      const auto at = static_cast<Eigen::Index>(i);
      columns[m].eta.col(at) = particles->prediction.eta[point].col(of.state);
      columns[m].nu.col(at) = particles->prediction.nu[point].col(of.state);
      columns[m].hold(at, particles->task(), k, particles->open_inputs(of));
    }
    columns[m].step(lanes[m].front().particles->task().samples->dt_s);
    for (std::size_t i = 0; i < lanes[m].size(); ++i) {
      const auto& [particles, of, column] = lanes[m][i];
      const auto at = static_cast<Eigen::Index>(i);
      particles->prediction.eta[point + 1].col(column) = columns[m].eta.col(at);
      particles->prediction.nu[point + 1].col(column) = columns[m].nu.col(at) + particles->disturbed(of, k);
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
  sequences.reserve(tasks.size());
  Eigen::Index longest = 0;
  for (const SequenceTask& task : tasks) {
    sequences.emplace_back(task, ensemble, options);
    longest = std::max(longest, task.range.size);
  }
  std::vector<Columns> columns;
  columns.reserve(static_cast<std::size_t>(ensemble.members()));
  for (int m = 0; m < ensemble.members(); ++m)
    columns.emplace_back(evaluator, m, options.integrator, inputs.sampled_actuators().size());

  if (options.sampling == Sampling::ts1) {
    for (Eigen::Index k = 0; k + 1 < longest; ++k) propagate_step(columns, sequences, k);
  } else {
    // The columns of the first step are those of all others.
    std::vector<std::vector<ParticleColumn>> first(sequences.size());
    for (std::size_t s = 0; s < sequences.size(); ++s)
      for (Eigen::Index k = 0; k < sequences[s].steps(); ++k) {
        const std::vector<ParticleColumn>& distinct = sequences[s].begin_step();
        if (k == 0) first[s] = distinct;
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
