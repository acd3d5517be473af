#include "gap/decide/found.hpp"

#include <algorithm>
#include <cmath>

namespace leeway::gap {

std::size_t far_parameters(const NullFit& fit, const Policy& policy) {
  return static_cast<std::size_t>(std::count_if(
      fit.parameters.begin(), fit.parameters.end(),
      [&](const ParameterShift& shift) { return std::abs(shift.shift_sd) > policy.decide.far_parameter_sd; }));
}

double error_share(const NullFit& fit) { return fit.sigma_w.cwiseQuotient(fit.typical).maxCoeff(); }

bool errs_grossly(const NullFit& fit, const Policy& policy) {
  return errs_grossly(far_parameters(fit, policy), error_share(fit), policy);
}

std::vector<std::string> sensors_claimed(const Findings& findings) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.insert(names.begin(), name);
  };
  if (!findings.conventions.contradicted.empty()) add("convention");
  for (const Fault& fault : findings.audit.faults) add(fault.name);
  return names;
}

SensorsFound sensors_found(const Findings& findings) {
  SensorsFound found;
  found.count = findings.conventions.contradicted.size() + findings.audit.faults.size();
  if (!findings.conventions.contradicted.empty()) found.p_value = 0.0;
  for (const Fault& fault : findings.audit.faults) found.p_value = std::min(found.p_value, fault.p_value);
  return found;
}

TestsFound tests_found(const Findings& findings, double intervals_p, const Policy& policy) {
  const Detection& d = findings.detection;
  TestsFound found;
  found.converged = findings.fit.converged;
  found.effects_p = d.p_value;
  found.intervals_p = intervals_p;
  found.heldout_gain = d.heldout_gain;
  found.heldout_gain_sd = d.heldout_gain_sd;
  found.error_share = error_share(findings.fit);
  found.is_noise_free = findings.fit.is_noise_free;
  for (const Interval& interval : findings.located.intervals) {
    if (interval.is_untrained())
      ++found.untrained_intervals;
    else if (interval.is_small)
      ++found.small_intervals;
  }
  found.samples = findings.fit.samples;
  found.effects_tested = d.effects.size();
  found.far_parameters = far_parameters(findings.fit, policy);
  return found;
}

}  // namespace leeway::gap
