#pragma once

#include <optional>
#include <vector>

#include "gap/fit/null_fit.hpp"
#include "gap/sensors/froude_scale.hpp"

namespace leeway::gap {

/// Recordings as the sensors gave them, followed by the simulator with faults in the measurement function: likelihoods
/// of faults of every kind are of the same data, where corrected recordings would be other data for each.
class SensedCampaign {
 public:
  ///   recorded  without correction
  ///   near_by   the simulator fitted to the corrected recordings, on the same points of time
  SensedCampaign(Campaign recorded, const FittedNull& near_by, const FroudeScale& scale, std::size_t jobs);

  /// ln p(recordings | faults), by Laplace's method, coefficients and noise levels fitted as well. The faults get the
  /// likeliest numbers, their standard deviations and sentences; a current keeps its own. Nothing where the points of
  /// time differ, or no likeliest numbers are found.
  std::optional<double> fit(std::vector<Fault>& faults) const;

 private:
  Campaign recorded_;
  const FittedNull& near_by_;
  FroudeScale scale_;
  std::size_t jobs_;
};

}  // namespace leeway::gap
