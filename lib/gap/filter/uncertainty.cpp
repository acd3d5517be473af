#include "gap/filter/uncertainty.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

UncertainParameter timing_parameter() { return {kTiming, 1.0, 2.0}; }

std::vector<UncertainParameter> uncertain_parameters(const Ship& ship) {
  std::vector<UncertainParameter> parameters;
  for (const Coefficient& coefficient : Model<double>(ship).coefficients())
    parameters.push_back({coefficient.name, coefficient.log_sd,
                          kPolicy.filter.tolerated * std::max(coefficient.log_sd, kPolicy.filter.least_stated_log_sd)});
  parameters.push_back(timing_parameter());
  for (const Ship::Uncertainty& given : ship.uncertainty) {
    const auto found = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const UncertainParameter& p) { return p.name == given.name; });
    if (found == parameters.end()) {
      std::vector<std::string> known;
      for (const UncertainParameter& p : parameters) known.push_back(p.name);
      throw InputError(ship.file, 0, "/uncertainty/" + given.name,
                       fmt::format("not an uncertain parameter of this ship; known: {}", fmt::join(known, ", ")));
    }
    found->log_sd = given.log_sd;
    found->tolerated_sd = 2.0 * given.log_sd;
  }
  return parameters;
}

}  // namespace leeway::gap
