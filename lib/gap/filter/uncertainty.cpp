#include "gap/filter/uncertainty.hpp"

#include <algorithm>

#include "gap/policy/policy.hpp"

namespace leeway::gap {

CoefficientFactor changed(const UncertainParameter& parameter, double theta) {
  return leeway::changed({parameter.name, parameter.sd, true, parameter.is_absolute, parameter.value}, theta);
}

UncertainParameter timing_parameter() { return {kTiming, 1.0, 2.0}; }

std::vector<UncertainParameter> uncertain_parameters(const Ship& ship) {
  std::vector<UncertainParameter> parameters;
  for (const UncertainCoefficient& c : coefficient_law(ship).coefficients) {
    const double least = c.is_stated ? 0.0 : kPolicy.filter.least_stated_log_sd;
    parameters.push_back({c.name, c.sd, kPolicy.filter.tolerated * std::max(c.sd, least), c.is_absolute, c.value});
  }
  parameters.push_back(timing_parameter());
  for (const Ship::Uncertainty& given : ship.uncertainty)
    if (given.name == kTiming) parameters.back() = {kTiming, given.sd, kPolicy.filter.tolerated * given.sd};
  return parameters;
}

}  // namespace leeway::gap
