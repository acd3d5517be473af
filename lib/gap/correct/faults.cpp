#include "gap/correct/faults.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "gap/decide/decide.hpp"
#include "gap/decide/sensors.hpp"
#include "gap/sensors/audit.hpp"
#include "gap/sensors/sensor_faults.hpp"

namespace leeway::gap {

void share_rate(Audit& audit) {
  for (std::vector<Fault>* faults : {&audit.faults, &audit.hypotheses})
    for (Fault& fault : *faults) {
      fault.p_value = std::min(1.0, kPolicy.decide.families * fault.p_value);
      for (Fault& rival : fault.rivals) rival.p_value = std::min(1.0, kPolicy.decide.families * rival.p_value);
    }
}

bool is_faint(const Fault& fault, double false_alarm) { return is_faint(fault.p_value, false_alarm); }

bool is_early(const Fault& fault) { return traits_of(fault.name).is_late_only && fault.parameters.front().value < 0.0; }

bool can_be_compared(const Fault& fault) { return traits_of(fault.name).shows_in_forces; }

void withdraw(Findings& findings, std::vector<Fault> certain, const std::string& why) {
  std::vector<Fault>& faults = findings.audit.faults;
  for (const Fault& fault : faults)
    if (std::none_of(certain.begin(), certain.end(), [&](const Fault& c) { return c.name == fault.name; }))
      findings.audit.notices.push_back(
          fmt::format("{} (p = {:.2g}): not so, since {}", fault.sentence, fault.p_value, why));
  faults = std::move(certain);
}

double log_jacobian(const std::vector<Fault>& faults, const std::vector<Trajectory>& recordings) {
  double sum = 0.0;
  for (const Fault& fault : faults)
    for (const Estimate& scale : fault.parameters) {
      const FaultParameterInfo* parameter = find_fault_parameter(scale.name);
      if (parameter == nullptr || !parameter->scaled) continue;
      for (const Trajectory& recording : recordings)
        sum -= std::log1p(scale.value) * static_cast<double>(std::count_if(
                                             recording[*parameter->scaled].begin(), recording[*parameter->scaled].end(),
                                             [](double value) { return std::isfinite(value); }));
    }
  return sum;
}

void refine(std::vector<Fault>& faults, const std::function<double(const std::vector<Fault>&)>& evidence_of) {
  const std::vector<Fault> of_audit = faults;
  for (int round = 0; round < kPolicy.decide.refined_rounds; ++round)
    for (std::size_t f = 0; f < faults.size(); ++f) {
      if (!can_be_compared(faults[f])) continue;
      std::vector<Estimate>& numbers = faults[f].parameters;
      for (std::size_t i = 0, next = 0; i < numbers.size(); i = next) {
        // Several channels may have one number.
        const Estimate now = numbers[i], &audited = of_audit[f].parameters[i];
        while (next < numbers.size() && numbers[next].value == now.value && numbers[next].sd == now.sd) ++next;
        const auto set = [&](double value) {
          for (std::size_t k = i; k < next; ++k) numbers[k].value = value;
        };
        const double step = kPolicy.decide.refined_step_sd * now.sd;
        if (round > 0 && std::abs(now.value - audited.value) <= step) continue;
        const auto evidence_at = [&](double value) {
          set(value);
          return evidence_of(faults);
        };
        const double here = evidence_at(now.value), above = evidence_at(now.value + step),
                     below = evidence_at(now.value - step);
        const double slope = (above - below) / (2.0 * step), curvature = (above + below - 2.0 * here) / (step * step);
        set(curvature < 0.0 ? std::clamp(now.value - slope / curvature,
                                         audited.value - kPolicy.decide.refined_limit_sd * audited.sd,
                                         audited.value + kPolicy.decide.refined_limit_sd * audited.sd)
                            : now.value);
      }
    }
  for (Fault& fault : faults)
    if (can_be_compared(fault)) rephrase(fault);
}

}  // namespace leeway::gap
