#include "gap/uncertainty.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"

namespace leeway::gap {

UncertainParameter timing_parameter() { return {kTiming, 1.0, 2.0}; }

std::vector<UncertainParameter> uncertain_parameters(const Ship& ship) {
  std::vector<UncertainParameter> parameters;
  Model<double> model(ship);
  for_each_coefficient(model.inertia, model.modules, [&](const char* name, double log_sd, const auto&) {
    parameters.push_back({name, log_sd, 2.0 * std::max(log_sd, 0.1)});
  });
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
