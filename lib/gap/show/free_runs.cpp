#include "gap/show/free_runs.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/parallel.hpp"
#include "core/units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// Within which a standard normal number lies with so many per cent.
const std::map<int, double> kQuantiles{
    {50, 0.6744897501960817}, {90, 1.6448536269514722}, {95, kPolicy.show.normal95}, {99, 2.5758293035489004}};

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

// Calls visit(k, x, is_first) at each point reached; `is_first` where a run begins.
template <typename Visit>
Squares run_free(const Model<double>& model, const Campaign& campaign, const Stretch& stretch, const Smoothed& start,
                 const Run& run, double horizon_s, const Visit& visit) {
  const RudderResponse& response = model.rudder_response();
  std::optional<RecordedInputs> otherwise;
  if (response != rudder_response_of(campaign.ship))
    otherwise = campaign.recorded_inputs[stretch.recording].through(response);
  Squares squares;
  for (std::size_t k = run.begin; k + 1 < run.end;) {
    StateVector x = start.state[k];
    x.tail<kStates - kErrorStart>().setZero();
    const double end_s = stretch.t_s[k] + horizon_s;
    visit(k, x, true);
    while (k + 1 < run.end && stretch.t_s[k + 1] <= end_s + kPolicy.show.time_tolerance_s) {
      std::vector<StepInputs<double>> inputs = stretch.inputs[k];
      const double h = stretch.dt_s(k) / static_cast<double>(inputs.size());
      if (otherwise)
        for (std::size_t i = 0; i < inputs.size(); ++i)
          inputs[i] = averaged_step(*otherwise, stretch.t_s[k] + static_cast<double>(i) * h, h);
      x.head<kShipStates>() = advance<double>(model, x, inputs, h);
      ++k;
      if (!x.allFinite() || x.segment<2>(3).norm() > kPolicy.show.most_speed_mps) {
        Squares away;  // counted as what it is
        away.u = away.vm = away.r = away.position = std::numeric_limits<double>::infinity();
        away.n_u = away.n_vm = away.n_r = away.n_position = 1;
        return away;
      }
      squares.add(stretch.measured[k] - x.head<kShipStates>());
      visit(k, x, false);
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
      for (const std::int64_t horizon_s : kPolicy.show.horizons_s) tasks.push_back({i, r, static_cast<int>(horizon_s)});
  }
  std::vector<Squares> squares(tasks.size());
  parallel_for(tasks.size(), jobs, [&](std::size_t i) {
    const Run& run = ships[tasks[i].ship].runs[tasks[i].run];
    squares[i] = run_free(models[tasks[i].ship], campaign, campaign.stretches[run.stretch], starts[run.stretch], run,
                          tasks[i].horizon_s, [](std::size_t, const StateVector&, bool) {});
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

double log_error(const Scores& scores) {
  double sum = 0.0, n = 0.0;
  for (const auto& [horizon_s, score] : scores.free_runs)
    for (const double error : {score.rmse_u_mps, score.rmse_vm_mps, score.rmse_r_degps, score.rmse_position_m})
      if (!std::isnan(error)) sum += std::log(std::max(error, kPolicy.show.least_error)), n += 1.0;
  return n > 0.0 ? sum / n : kMissing;
}

bool is_beyond_chance(const Campaign& campaign, const std::vector<Smoothed>& starts,
                      const std::vector<ShipOnRuns>& before, const std::vector<ShipOnRuns>& after, std::size_t jobs) {
  double n = 0.0, sum = 0.0, square = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double fall = log_error(free_runs(campaign, starts, {before[i]}, jobs)) -
                        log_error(free_runs(campaign, starts, {after[i]}, jobs));
    if (std::isnan(fall)) continue;  // nothing was left out there
    n += 1.0;
    sum += fall;
    square += fall * fall;
  }
  // A single part says nothing of its scatter.
  return n > 1.0 && sum / n > std::sqrt(std::max(0.0, square / n - sum * sum / (n * n)) / (n - 1.0));
}

std::vector<FreeTrack> free_tracks(const Campaign& campaign, const std::vector<Smoothed>& starts,
                                   const std::vector<ShipOnRuns>& ships) {
  std::vector<FreeTrack> tracks(campaign.recordings.size());
  for (std::size_t r = 0; r < tracks.size(); ++r) tracks[r].recording = campaign.recordings[r].name;
  for (const ShipOnRuns& one : ships) {
    const Model<double> model(one.ship);
    for (const Run& run : one.runs) {
      const Stretch& stretch = campaign.stretches[run.stretch];
      FreeTrack& track = tracks[stretch.recording];
      run_free(model, campaign, stretch, starts[run.stretch], run, kShownHorizon_s,
               [&](std::size_t k, const StateVector& x, bool is_first) {
                 const Vec6 nothing = Vec6::Constant(kMissing);
                 if (is_first && !track.run.empty()) track.add(kMissing, nothing, nothing);
                 track.add(stretch.t_s[k], stretch.measured[k], x.head<kShipStates>());
               });
    }
  }
  std::erase_if(tracks, [](const FreeTrack& track) { return track.t_s.empty(); });
  return tracks;
}

std::map<int, double> coverage(const std::vector<Smoothed>& smoothed, const std::vector<Run>& runs) {
  std::map<int, double> inside{{50, 0.0}, {90, 0.0}, {95, 0.0}, {99, 0.0}};
  double n = 0.0;
  for (const Run& run : runs)
    for (std::size_t k = std::max(run.begin, kPolicy.filter.first_points); k < run.end; ++k)
      for (int i = 0; i < kShipStates; ++i) {
        const double z = smoothed[run.stretch].innovations[k][i];
        if (std::isnan(z)) continue;
        n += 1.0;
        for (auto& [percent, count] : inside) count += std::abs(z) < kQuantiles.at(percent) ? 1.0 : 0.0;
      }
  for (auto& [percent, count] : inside) count = n > 0.0 ? count / n : kMissing;
  return inside;
}

}  // namespace leeway::gap
