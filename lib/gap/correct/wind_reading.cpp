#include "gap/correct/wind_reading.hpp"

#include <algorithm>

#include <fmt/format.h>

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

std::optional<Reading> wind_reading(const Campaign& campaign, const FittedNull& fit, const Conventions& conventions,
                                    const GapLocateOptions& options) {
  FitOptions fit_options;
  fit_options.jobs = options.jobs;
  std::optional<Reading> result;
  Campaign best;
  FittedNull best_fit;
  const double as_stated = log_evidence(fit);
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
    FittedNull fit_otherwise = fit_null(otherwise, fit_options, &fit);
    const double gained = log_evidence(fit_otherwise) - as_stated;
    if (!(gained > least)) continue;  // nor where it is not identifiable
    least = gained;
    best = without_outliers(std::move(otherwise), fit_otherwise);
    best_fit = std::move(fit_otherwise);
    result = reading;
    result->log_odds = gained;
    result->sentence =
        fmt::format("{}, the recordings are likelier than as stated (log-odds {:.0f})", reading.premise, gained);
  }
  if (!result) return result;
  const double limit = best_evidence(campaign, fit, options) + kPolicy.decide.far_likelier;
  if (as_stated + least < limit && best_evidence(best, best_fit, options) < limit) result.reset();
  return result;
}

}  // namespace leeway::gap
