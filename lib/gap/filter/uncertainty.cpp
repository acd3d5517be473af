#include "gap/filter/uncertainty.hpp"

#include <algorithm>

#include "effects/description.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

CoefficientFactor changed(const UncertainParameter& parameter, double theta) {
  return leeway::changed({parameter.name, parameter.sd, true, parameter.is_absolute, parameter.value}, theta);
}

UncertainParameter timing_parameter() { return {kTiming, kPolicy.filter.actuator_timing_sd}; }

std::vector<UncertainParameter> uncertain_parameters(const Ship& ship) {
  std::vector<UncertainParameter> parameters;
  for (const UncertainCoefficient& c : coefficient_law(ship).coefficients) {
    UncertainParameter parameter{c.name, c.sd, c.is_absolute, c.value, !c.is_form, !c.is_form, c.is_form};
    for (const auto& [info, effect_parameters] : effect_catalogue()) {
      if (std::ranges::find(info.coefficients, c.name) == info.coefficients.end()) continue;
      if (!info.cause_of_more.empty()) parameter.may_be_far_more = false;
      if (!info.cause_of_less.empty()) parameter.may_be_far_less = false;
    }
    parameters.push_back(std::move(parameter));
  }
  parameters.push_back(timing_parameter());
  for (const Ship::Uncertainty& given : ship.uncertainty)
    if (given.name == kTiming) parameters.back().sd = given.sd;
  return parameters;
}

}  // namespace leeway::gap
