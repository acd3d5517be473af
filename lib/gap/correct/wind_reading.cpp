#include "gap/correct/wind_reading.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "gap/compare/comparison.hpp"
#include "gap/sensors/conventions.hpp"
#include "gap/sensors/readings.hpp"

namespace leeway::gap {

double best_evidence(const Campaign& campaign, const FittedNull& fit, const GapLocateOptions& options) {
  Comparison comparison(campaign, fit, {options.false_alarm, options.jobs, options.seed});
  double best = comparison.none().log_evidence;
  const std::vector<Comparison::ExpectedGain> candidates = comparison.expected_gains(0);
  for (std::size_t i = 0; i < std::min(candidates.size(), kPolicy.decide.most_compared); ++i)
    if (const auto added = comparison.add(0, candidates[i].starts))
      best = std::max(best, comparison.all()[*added].log_evidence);
  return best;
}

namespace {

// The fit continued where the recordings are read otherwise: of the same measurements, with the same noise of the
// sensors. A fit of its own may end at another optimum of the noise, or leave out other outliers, and be likelier
// whatever the wind is. Nothing where the simulator runs away.
std::optional<FittedNull> continued(const Campaign& campaign, FittedNull fit, std::size_t jobs) {
  for (std::size_t s = 0; s < fit.stretches.size(); ++s)
    fit.stretches[s].data = std::make_shared<const Stretch>(campaign.stretches[s]);
  FitOptions options;
  options.jobs = jobs;
  try {
    return fit_with(campaign, fit, {}, fit.theta, options);
  } catch (const NumericalError&) {
    return std::nullopt;
  }
}

}  // namespace

std::optional<Reading> wind_reading(const Campaign& campaign, const FittedNull& fit, const Conventions& conventions,
                                    const GapLocateOptions& options) {
  std::optional<Reading> result;
  Campaign best;
  FittedNull best_fit;
  std::optional<FittedNull> stated;
  double least = kPolicy.decide.far_likelier;
  for (const Reading& reading : conventions.tested) {
    const ReadingEntry* entry = find_reading(reading.channel, reading.name);
    const bool is_wind = reading.recording.empty() && entry != nullptr && entry->asks_fit;
    if (!campaign.has_wind || !is_wind || reading.log_odds < -kPolicy.decide.open_reading) continue;
    Campaign otherwise = campaign;
    for (std::size_t r = 0; r < campaign.recordings.size(); ++r) {
      otherwise.recordings[r] = reread(campaign.recordings[r], {reading});
      otherwise.recorded_inputs[r] =
          RecordedInputs(otherwise.recordings[r], campaign.ship, InputInterpolation::at_actuator_rate);
    }
    const RudderResponse response = rudder_response_of(campaign.ship);
    for (Stretch& stretch : otherwise.stretches)
      set_inputs(stretch, otherwise.recorded_inputs[stretch.recording].through(response), campaign.ship);
    if (!stated) stated = continued(campaign, fit, options.jobs);
    if (!stated) return std::nullopt;
    std::optional<FittedNull> read_otherwise = continued(otherwise, fit, options.jobs);
    if (!read_otherwise) continue;
    const double gained = log_evidence(*read_otherwise) - log_evidence(*stated);
    if (!(gained > least)) continue;  // nor where it is not identifiable
    least = gained;
    best = std::move(otherwise);
    best_fit = *std::move(read_otherwise);
    result = reading;
    result->log_odds = gained;
    result->sentence =
        fmt::format("{}, the recordings are likelier than as stated (log-odds {:.0f})", reading.premise, gained);
  }
  if (!result) return result;
  const double limit = best_evidence(campaign, fit, options) + kPolicy.decide.far_likelier;
  if (log_evidence(*stated) + least < limit && best_evidence(best, best_fit, options) < limit) result.reset();
  return result;
}

}  // namespace leeway::gap
