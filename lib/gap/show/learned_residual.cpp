#include "gap/show/learned_residual.hpp"

#include <algorithm>
#include <cmath>

#include "core/errors.hpp"
#include "ensemble/residual_training.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// The recordings without what lies in some runs.
std::vector<Trajectory> without(const Campaign& campaign, const std::vector<Run>& runs) {
  std::vector<Trajectory> rest = campaign.recordings;
  for (const Run& run : runs) {
    const Stretch& stretch = campaign.stretches[run.stretch];
    Trajectory& recording = rest[stretch.recording];
    const double from_s = stretch.t_s[run.begin], to_s = stretch.t_s[run.end - 1];
    for (std::size_t i = 0; i < recording.size(); ++i)
      if (const double t = recording[Channel::t][i]; t >= from_s && t <= to_s)
        for (const Channel channel : kMeasured)
          if (recording.has(channel)) recording[channel][i] = kMissing;
  }
  std::erase_if(rest, [](const Trajectory& recording) {
    return std::all_of(recording[Channel::u].begin(), recording[Channel::u].end(),
                       [](double u) { return std::isnan(u); });
  });
  return rest;
}

}  // namespace

LearnedResidual learn_residual(const Campaign& campaign, const std::vector<Smoothed>& starts, const Ship& ship,
                               const std::vector<std::vector<Run>>& folds, const Noise& noise, std::uint64_t seed,
                               std::size_t jobs) {
  LearnedResidual result;
  const ensemble::ResidualTraining training{campaign.step_s, noise.measurement_sd.tail<3>(), seed, jobs};
  try {
    std::vector<ShipOnRuns> plain, with;
    for (const std::vector<Run>& runs : folds) {
      result.by_fold.push_back(ensemble::learn_residual(ship, without(campaign, runs), training));
      plain.push_back({ship, runs});
      with.push_back({ship, runs});
      with.back().ship.residual_network = result.by_fold.back();
    }
    result.log_error_without = log_error(free_runs(campaign, starts, plain, jobs));
    result.log_error_with = log_error(free_runs(campaign, starts, with, jobs));
    if (result.log_error_with < result.log_error_without - kPolicy.show.worthwhile_fall &&
        is_beyond_chance(campaign, starts, plain, with, jobs))
      result.network = ensemble::learn_residual(ship, campaign.recordings, training);
  } catch (const InputError& error) {
    result.problem = error.what();
  } catch (const NumericalError& error) {
    result.problem = error.what();
  }
  return result;
}

}  // namespace leeway::gap
