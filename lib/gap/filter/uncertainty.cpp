#include "gap/filter/uncertainty.hpp"

#include <algorithm>

#include "gap/policy/policy.hpp"

namespace leeway::gap {

CoefficientFactor changed(const UncertainParameter& parameter, double theta) {
  return leeway::changed({parameter.name, parameter.sd, true, parameter.is_absolute, parameter.value}, theta);
}

UncertainParameter timing_parameter() { return {kTiming, kPolicy.filter.actuator_timing_sd}; }

std::vector<UncertainParameter> uncertain_parameters(const Ship& ship) {
  std::vector<UncertainParameter> parameters;
  for (const UncertainCoefficient& c : coefficient_law(ship).coefficients)
    parameters.push_back({c.name, c.sd, c.is_absolute, c.value});
  parameters.push_back(timing_parameter());
  for (const Ship::Uncertainty& given : ship.uncertainty)
    if (given.name == kTiming) parameters.back().sd = given.sd;
  return parameters;
}

}  // namespace leeway::gap
