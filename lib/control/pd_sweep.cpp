#include "control/pd_sweep.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <optional>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "dynamics/maneuvers.hpp"
#include "io/csv.hpp"
#include "ship/pitch_current.hpp"

namespace leeway::control {
namespace {

constexpr double kSample_s = 1.0;   // of the runs that are kept
constexpr long kMostGains = 10000;  // in one range

long whole_steps(const char* name, double time_s, double dt_s) {
  const double ratio = time_s / dt_s;
  if (ratio < 0.5 || ratio > 1e9 || std::abs(ratio - std::round(ratio)) > 1e-6)
    throw UsageError(fmt::format("{} must be a multiple of --dt-s, but {} s is not one of {} s", name, time_s, dt_s));
  return std::lround(ratio);
}

// The closed loop of many gain pairs side by side, without the motion: commands, actuators, score, samples.
class Lanes {
 public:
  Lanes(const Ship& ship, const std::vector<PdGains>& gains, const HeadingTask& task, bool keep_runs)
      : ship_(ship),
        gains_(gains),
        task_(task),
        every_(keep_runs ? whole_steps("the samples of --trajectories", kSample_s, task.dt_s) : 1) {
    actuators_.assign(gains.size(), start_actuators(ship));
    scores.assign(gains.size(), 0.0);
    if (keep_runs) runs.resize(gains.size());
  }

  static Actuators<double> start_actuators(const Ship& ship) {
    Actuators<double> start = ship.initial_actuators();
    for (const Actuator& a : ship.actuators)
      if (a.is_rudder() || a.is_thruster()) start[a.channel] = a.clip(0.0);
    return start;
  }

  const Ship& ship() const { return ship_; }
  const Actuators<double>& actuators(std::size_t lane) const { return actuators_[lane]; }

  // What the controller orders, and how the actuators move over the step.
  StepInputs<double> step_inputs(std::size_t lane, double psi, double r) {
    Actuators<double> command = start_actuators(ship_);
    const double order = gains_[lane].command(psi - task_.psi_bar, r);
    order_rudders(ship_, order, command);  // respond() clips to each rudder's range
    StepInputs<double> inputs = respond(ship_, actuators_[lane], command, Vec2<double>::Zero(), task_.dt_s);
    actuators_[lane] = inputs.end.actuators;
    return inputs;
  }

  // Sample `step` of `steps`: half weight for the first and the last.
  void score(std::size_t lane, long step, long steps, const Vec3<double>& eta, const Vec3<double>& nu) {
    const double weight = step == 0 || step == steps ? 0.5 : 1.0;
    scores[lane] += weight * task_.dt_s * (std::abs(eta(2) - task_.psi_bar) + std::abs(nu(2)));
    if (runs.empty() || step % every_ != 0) return;
    runs[lane].eta.push_back(eta);
    runs[lane].nu.push_back(nu);
    for (const Actuator& a : ship_.actuators)
      if (a.is_rudder()) runs[lane].rudder.push_back(actuators_[lane][a.channel]);
  }

  std::vector<double> scores;
  std::vector<ControlledRun> runs;

 private:
  const Ship& ship_;
  const std::vector<PdGains>& gains_;
  const HeadingTask& task_;
  long every_;
  std::vector<Actuators<double>> actuators_;
};

void run_true_ship(const Ship& ship, const HeadingTask& task, std::size_t lane, long steps, Lanes& lanes) {
  SimulatedShip simulated(ship, task.u0_mps);
  for (long k = 0; k <= steps; ++k) {
    lanes.score(lane, k, steps, simulated.state.eta, simulated.state.nu);
    if (k == steps) break;
    const StepInputs<double> inputs = lanes.step_inputs(lane, simulated.state.eta(2), simulated.state.nu(2));
    simulated.advance(inputs, task.dt_s);
    if (!simulated.is_finite())
      throw NumericalError(
          fmt::format("the true ship's run is no finite number at t = {} s", grid_time(k + 1, task.dt_s)));
  }
}

// What is driven through all gains: a member, for one of its particles where each is disturbed in its own way.
struct DisturbedMember {
  int member;
  std::optional<std::uint64_t> particle;
};

void run_member(const ensemble::Ensemble& ensemble, const DisturbedMember& run, const HeadingTask& task,
                const ensemble::Disturbance& disturbance, std::uint64_t seed, std::size_t count, long steps,
                Lanes& lanes) {
  const int member = run.member;
  RandomStream random(seed, "disturbance of the gain sweep", run.particle.value_or(0));
  ensemble::DisturbancePath path(run.particle ? disturbance : ensemble::Disturbance(), task.dt_s, random);
  ensemble::EnsembleEvaluator evaluator(ensemble);
  const std::vector<Channel> channels = ensemble.header().inputs.sampled_actuators();
  const auto n = static_cast<Eigen::Index>(count);
  Eigen::Matrix3Xd eta = Eigen::Matrix3Xd::Zero(3, n), nu = Eigen::Matrix3Xd::Zero(3, n);
  nu.row(0).setConstant(task.u0_mps);
  Eigen::MatrixXd held(static_cast<Eigen::Index>(channels.size()), n);
  for (long k = 0; k <= steps; ++k) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto lane = static_cast<std::size_t>(i);
      lanes.score(lane, k, steps, eta.col(i), nu.col(i));
      // The networks know inputs that are held over a step: those in the middle of it.
      const StepInputs<double> inputs = lanes.step_inputs(lane, eta(2, i), nu(2, i));
      for (std::size_t c = 0; c < channels.size(); ++c)
        held(static_cast<Eigen::Index>(c), i) = value_of(channels[c], inputs.middle.actuators, lanes.ship());
    }
    if (k == steps) break;
    evaluator.step(member, Integrator::rk4, task.dt_s, held, Vec2<double>::Zero(), eta, nu,
                   Eigen::RowVectorXd::Constant(1, grid_time(static_cast<std::size_t>(k), task.dt_s)));
    nu.colwise() += task.dt_s * path.next(random);
    if (!nu.allFinite() || !eta.allFinite())
      throw NumericalError(
          fmt::format("member {}: a run is no finite number at t = {} s", member, grid_time(k + 1, task.dt_s)));
  }
}

}  // namespace

std::vector<SweepResult> pd_sweep(const Ship& ship, const ensemble::Ensemble& ensemble,
                                  const std::vector<PdGains>& gains, const HeadingTask& task, int particles,
                                  std::uint64_t seed, std::size_t jobs, bool keep_runs,
                                  const ensemble::Disturbance& disturbance,
                                  const std::function<void(double)>& progress) {
  for (const Channel channel : ensemble.header().inputs.sampled_actuators())
    if (!knows(ship, channel))
      throw UsageError(
          fmt::format("the ensemble needs '{}', which the ship {} does not have", column_name(channel), ship.name));
  const long steps = whole_steps("--duration-s", task.duration_s, task.dt_s);
  const std::size_t members = static_cast<std::size_t>(ensemble.members());

  RandomStream random(seed, "particles of the gain sweep");
  const std::vector<int> member_of = ensemble::shared_out(static_cast<std::size_t>(particles), members, random);
  // First a run for each member; with a disturbance, its further particles behind.
  std::vector<DisturbedMember> driven;
  std::vector<double> weight(members, 0.0);  // particles that a run stands for
  for (std::size_t m = 0; m < members; ++m) driven.push_back({static_cast<int>(m), std::nullopt});
  for (std::size_t p = 0; p < member_of.size(); ++p) {
    const auto m = static_cast<std::size_t>(member_of[p]);
    if (disturbance.is_zero() || weight[m] == 0.0) {
      weight[m] += 1.0;
      if (!disturbance.is_zero()) driven[m].particle = p;
    } else {
      driven.push_back({member_of[p], p});
      weight.push_back(1.0);
    }
  }

  // The true ship by gain pair, then the networks by run with the gain pairs as lanes.
  std::atomic<std::size_t> done{0};
  const auto one_more = [&] {
    if (progress) progress(static_cast<double>(++done) / static_cast<double>(gains.size() + driven.size()));
  };
  Lanes true_lanes(ship, gains, task, keep_runs);
  parallel_for(gains.size(), jobs, [&](std::size_t lane) {
    run_true_ship(ship, task, lane, steps, true_lanes);
    one_more();
  });
  std::vector<Lanes> lanes(driven.size(), Lanes(ship, gains, task, keep_runs));
  parallel_for(driven.size(), jobs, [&](std::size_t i) {
    run_member(ensemble, driven[i], task, disturbance, seed, gains.size(), steps, lanes[i]);
    one_more();
  });

  std::vector<SweepResult> results(gains.size());
  for (std::size_t i = 0; i < gains.size(); ++i) {
    SweepResult& result = results[i];
    result.gains = gains[i];
    result.score_true = true_lanes.scores[i];
    result.score_best = INFINITY;
    if (keep_runs) result.run_true = std::move(true_lanes.runs[i]);
    for (std::size_t k = 0; k < driven.size(); ++k) {
      const double score = lanes[k].scores[i];
      if (k < members) {
        result.score_members.push_back(score);
        if (keep_runs) result.runs.push_back(std::move(lanes[k].runs[i]));
      }
      if (weight[k] == 0.0) continue;
      result.score_worst = std::max(result.score_worst, score);
      result.score_best = std::min(result.score_best, score);
    }
    // From the best one up, so that rounding cannot put the mean of equal scores beside them.
    result.score_mean = result.score_best;
    for (std::size_t k = 0; k < driven.size(); ++k)
      if (weight[k] > 0.0) result.score_mean += weight[k] * (lanes[k].scores[i] - result.score_best) / particles;
  }
  return results;
}

std::vector<double> parse_gain_range(const std::string& option, const std::string& text) {
  const auto fail = [&]() -> UsageError {
    return UsageError(
        fmt::format("{}: expected LOW:HIGH:STEP with STEP > 0, a list A,B,... or one number, got '{}'", option, text));
  };
  const char separator = text.find(':') != std::string::npos ? ':' : ',';
  std::vector<double> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    double value = 0.0;
    if (!io::parse_number(text.substr(begin, end - begin), value)) throw fail();
    numbers.push_back(value);
    begin = end + 1;
  }
  if (separator == ',') return numbers;
  if (numbers.size() != 3 || numbers[2] <= 0.0 || numbers[1] < numbers[0]) throw fail();
  const double steps = (numbers[1] - numbers[0]) / numbers[2] + 1e-9;
  if (steps >= kMostGains) throw UsageError(fmt::format("{}: '{}' has more than {} values", option, text, kMostGains));
  const auto count = static_cast<std::size_t>(steps) + 1;
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(numbers[0] + static_cast<double>(i) * numbers[2]);
  return values;
}

std::string sweep_csv(const std::vector<SweepResult>& results) {
  std::string text = "kp_deg_per_rad,kd_deg_per_radps,score_true,score_mean,score_worst,score_best";
  for (std::size_t m = 0; !results.empty() && m < results.front().score_members.size(); ++m)
    fmt::format_to(std::back_inserter(text), ",score_member_{:02}", m);
  text += '\n';
  for (const SweepResult& r : results) {
    fmt::format_to(std::back_inserter(text), "{},{}", r.gains.kp, r.gains.kd);
    const auto append = [&](double score) {
      text += ',';
      io::append_number(text, score);
    };
    for (const double score : {r.score_true, r.score_mean, r.score_worst, r.score_best}) append(score);
    for (const double score : r.score_members) append(score);
    text += '\n';
  }
  return text;
}

std::string runs_csv(const SweepResult& result, const Ship& ship) {
  std::string text = "model,t_s,x0_m,y0_m,psi_deg,u_mps,vm_mps,r_degps";
  std::size_t rudders = 0;
  for (const Actuator& a : ship.actuators)
    if (a.is_rudder()) {
      text += ',';
      text += column_name(a.channel);
      ++rudders;
    }
  text += '\n';
  const auto append = [&](const std::string& model, const ControlledRun& run) {
    for (std::size_t i = 0; i < run.eta.size(); ++i) {
      const Vec3<double>&eta = run.eta[i], &nu = run.nu[i];
      text += model;
      const auto put = [&](double value) {
        text += ',';
        io::append_number(text, value);
      };
      for (const double value :
           {kSample_s * static_cast<double>(i), eta(0), eta(1), rad_to_deg(eta(2)), nu(0), nu(1), rad_to_deg(nu(2))})
        put(value);
      for (std::size_t j = 0; j < rudders; ++j) put(rad_to_deg(run.rudder[i * rudders + j]));
      text += '\n';
    }
  };
  append("true", result.run_true);
  for (std::size_t m = 0; m < result.runs.size(); ++m) append(fmt::format("{:02}", m), result.runs[m]);
  return text;
}

}  // namespace leeway::control
