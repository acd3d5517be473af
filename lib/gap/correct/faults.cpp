#include "gap/correct/faults.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

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

bool can_be_compared(const Fault& fault) { return candidate_of(fault) != nullptr; }

void withdraw(Findings& findings, std::vector<Fault> certain, const std::string& why) {
  std::vector<Fault>& faults = findings.audit.faults;
  for (const Fault& fault : faults)
    if (std::none_of(certain.begin(), certain.end(), [&](const Fault& c) { return c.name == fault.name; }))
      findings.audit.notices.push_back(
          fmt::format("{} (p = {:.2g}): not so, since {}", fault.sentence, fault.p_value, why));
  faults = std::move(certain);
}

namespace {

// A fault with its numbers no farther from the audit's than those may be wrong.
Fault with_numbers_near(Fault fault, const Fault& audited) {
  fault.left_open.clear();
  for (std::size_t i = 0; i < fault.parameters.size(); ++i) {
    const Estimate& known = audited.parameters[i];
    const double far = kPolicy.decide.refined_limit_sd * known.sd;
    fault.parameters[i].value = std::clamp(fault.parameters[i].value, known.value - far, known.value + far);
    fault.left_open.push_back(far);
  }
  rephrase(fault);
  return fault;
}

// What may stand in the place of a fault: its rivals, and of what is late all others that are late, since kinematics
// alone take a filter for a latency.
std::vector<Fault> instead_of(const Fault& fault, const std::vector<Fault>& faults,
                              const std::vector<Fault>& hypotheses) {
  std::vector<Fault> result = fault.rivals;
  if (!traits_of(fault.name).is_late_only) return result;
  for (const Fault& other : hypotheses) {
    const auto is_same = [&](const Fault& known) { return candidate_of(known) == candidate_of(other); };
    if (!traits_of(other.name).is_late_only || is_early(other) || std::ranges::any_of(faults, is_same) ||
        std::ranges::any_of(result, is_same))
      continue;
    result.push_back(other);
  }
  return result;
}

}  // namespace

void refine(std::vector<Fault>& faults, const std::vector<Fault>& hypotheses,
            const std::function<std::optional<double>(std::vector<Fault>&)>& fit) {
  for (std::size_t f = 0; f < faults.size(); ++f) {
    struct Tried {
      Fault fault;
      double log_posterior;
    };
    std::vector<Tried> tried;
    const auto attempt = [&](const Fault& fault) {
      std::vector<Fault> with = faults;
      with[f] = fault;
      if (const std::optional<double> evidence = fit(with))
        tried.push_back({with_numbers_near(with[f], fault), *evidence + log_share_of_name(fault)});
    };
    const std::vector<Fault> instead = instead_of(faults[f], faults, hypotheses);
    std::vector<Fault> rivals;
    std::swap(rivals, faults[f].rivals);
    attempt(faults[f]);
    if (tried.empty()) {
      faults[f].rivals = std::move(rivals);
      continue;
    }
    for (const Fault& other : instead) attempt(other);
    std::ranges::stable_sort(tried, std::ranges::greater{}, &Tried::log_posterior);
    Fault likeliest = tried.front().fault;
    for (Tried& other : std::span(tried).subspan(1)) {
      likeliest.p_value = std::min(likeliest.p_value, other.fault.p_value);
      other.fault.log_odds = other.log_posterior - tried.front().log_posterior;
      if (other.fault.log_odds > -kPolicy.decide.contradicted) likeliest.rivals.push_back(std::move(other.fault));
    }
    likeliest.log_odds = 0.0;
    faults[f] = std::move(likeliest);
  }
}

}  // namespace leeway::gap
