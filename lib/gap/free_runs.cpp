#include "gap/free_runs.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "core/units.hpp"

namespace leeway::gap {
namespace {

constexpr std::array<int, 3> kHorizons_s{30, 100, 300};
constexpr double kQuantile_95 = 1.959963984540054;
constexpr double kSpeedLimit_mps = 1e3;  // beyond which a run has run away

struct Squares {
  double u = 0.0, vm = 0.0, r = 0.0, position = 0.0;
  std::size_t n_u = 0, n_vm = 0, n_r = 0, n_position = 0;

  void add(const Vec6& error) {
    const auto one = [](double e, double& sum, std::size_t& n) {
      if (std::isnan(e)) return;
      sum += e * e;
      ++n;
    };
    one(error[3], u, n_u);
    one(error[4], vm, n_vm);
    one(error[5], r, n_r);
    one(std::hypot(error[0], error[1]), position, n_position);
  }
  Squares& operator+=(const Squares& o) {
    u += o.u, vm += o.vm, r += o.r, position += o.position;
    n_u += o.n_u, n_vm += o.n_vm, n_r += o.n_r, n_position += o.n_position;
    return *this;
  }
  Score score() const {
    const auto root = [](double sum, std::size_t n) {
      return n > 0 ? std::sqrt(sum / static_cast<double>(n)) : kMissing;
    };
    return {std::max({n_u, n_vm, n_r, n_position}), root(u, n_u), root(vm, n_vm), root(r, n_r) / kDegree,
            root(position, n_position)};
  }
};

Squares run_free(const Model<double>& model, const Campaign& campaign, const Stretch& stretch, const Smoothed& start,
                 const Run& run, double horizon_s) {
  const double delay_s = model.effects.rudder_delay_s();
  const bool is_delayed = delay_s != Effects<double>(campaign.ship).rudder_delay_s();
  Squares squares;
  for (std::size_t k = run.begin; k + 1 < run.end;) {
    StateVector x = start.state[k];
    x.tail<kStates - kErrorStart>().setZero();
    const double end_s = stretch.t_s[k] + horizon_s;
    while (k + 1 < run.end && stretch.t_s[k + 1] <= end_s + 1e-9) {
      std::vector<StepInputs<double>> inputs = stretch.inputs[k];
      const double h = stretch.dt_s(k) / static_cast<double>(inputs.size());
      if (is_delayed)
        for (std::size_t i = 0; i < inputs.size(); ++i)
          inputs[i] = averaged_step(campaign.recorded_inputs[stretch.recording],
                                    stretch.t_s[k] + static_cast<double>(i) * h, h, delay_s);
      x.head<kShipStates>() = advance<double>(model, x, inputs, h);
      ++k;
      if (!x.allFinite() || x.segment<2>(3).norm() > kSpeedLimit_mps) {
        Squares away;  // counted as what it is
        away.u = away.vm = away.r = away.position = std::numeric_limits<double>::infinity();
        away.n_u = away.n_vm = away.n_r = away.n_position = 1;
        return away;
      }
      squares.add(stretch.measured[k] - x.head<kShipStates>());
    }
    if (k + 1 < run.end && stretch.t_s[k + 1] - stretch.t_s[k] > horizon_s) ++k;  // a hole longer than a run
  }
  return squares;
}

}  // namespace

std::vector<Run> whole_runs(const Campaign& campaign) {
  std::vector<Run> runs;
  for (std::size_t s = 0; s < campaign.stretches.size(); ++s) runs.push_back({s, 0, campaign.stretches[s].size()});
  return runs;
}

std::vector<Run> runs_of(const Campaign& campaign, const Blocks& blocks, const std::vector<std::size_t>& fold) {
  std::vector<Run> runs;
  for (const std::size_t i : fold) {
    const std::size_t s = blocks.stretch[i], begin = blocks.begin[i];
    const std::size_t end = std::min(begin + blocks.points, campaign.stretches[s].size());
    if (!runs.empty() && runs.back().stretch == s && runs.back().end == begin)
      runs.back().end = end;
    else
      runs.push_back({s, begin, end});
  }
  return runs;
}

Scores free_runs(const Campaign& campaign, const std::vector<Smoothed>& starts, const std::vector<ShipOnRuns>& ships,
                 std::size_t jobs) {
  struct Task {
    std::size_t ship, run;
    int horizon_s;
  };
  std::vector<Task> tasks;
  std::vector<Model<double>> models;
  for (std::size_t i = 0; i < ships.size(); ++i) {
    models.emplace_back(ships[i].ship);
    for (std::size_t r = 0; r < ships[i].runs.size(); ++r)
      for (const int horizon_s : kHorizons_s) tasks.push_back({i, r, horizon_s});
  }
  std::vector<Squares> squares(tasks.size());
  parallel_for(tasks.size(), jobs, [&](std::size_t i) {
    const Run& run = ships[tasks[i].ship].runs[tasks[i].run];
    squares[i] = run_free(models[tasks[i].ship], campaign, campaign.stretches[run.stretch], starts[run.stretch], run,
                          tasks[i].horizon_s);
  });
  std::map<int, Squares> sums;
  std::map<std::string, Squares> by_recording;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    sums[tasks[i].horizon_s] += squares[i];
    const Run& run = ships[tasks[i].ship].runs[tasks[i].run];
    if (tasks[i].horizon_s == kShownHorizon_s)
      by_recording[campaign.recordings[campaign.stretches[run.stretch].recording].name] += squares[i];
  }
  Scores scores;
  for (const auto& [horizon_s, sum] : sums) scores.free_runs[horizon_s] = sum.score();
  for (const auto& [name, sum] : by_recording) scores.by_recording[name] = sum.score();
  return scores;
}

double coverage(const std::vector<Smoothed>& smoothed) {
  double inside = 0.0, n = 0.0;
  for (const Smoothed& stretch : smoothed)
    for (std::size_t k = kSettling; k < stretch.innovations.size(); ++k)
      for (int i = 0; i < kShipStates; ++i) {
        const double z = stretch.innovations[k][i];
        if (std::isnan(z)) continue;
        n += 1.0;
        inside += std::abs(z) < kQuantile_95 ? 1.0 : 0.0;
      }
  return n > 0.0 ? inside / n : kMissing;
}

}  // namespace leeway::gap
