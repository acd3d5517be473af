#include "gap/gap_locate.hpp"

#include "core/errors.hpp"
#include "gap/decide/found.hpp"
#include "gap/detect/screen.hpp"
#include "gap/locate/locate.hpp"
#include "gap/policy/policy.hpp"
#include "gap/report/notices.hpp"
#include "gap/report/reasons.hpp"

namespace leeway::gap {
namespace {

// Whether this looks like another ship: parameters far off that neither repaired sensors nor the best effect of the
// catalogue bring back.
bool is_grossly_inconsistent(const Findings& findings, const Campaign& campaign, const FittedNull& null,
                             std::size_t jobs) {
  if (!findings.corrected && (!findings.audit.faults.empty() || !findings.conventions.contradicted.empty()))
    return false;
  if (!errs_grossly(null.report) || findings.detection.effects.empty()) return errs_grossly(null.report);
  const std::vector<Start> starts = starts_of(findings.detection.effects.front().name, campaign, null, jobs);
  FitOptions options;
  options.jobs = jobs;
  try {
    return errs_grossly(fit_with(campaign, null, starts.front().hypothesis, starts.front().theta, options).report);
  } catch (const NumericalError&) {  // with the effect the simulator runs away: it brings nothing back
    return true;
  }
}

// Verdict, reason, and where nothing is, nothing located.
void decide_findings(Findings& findings, double intervals_p) {
  const TestsFound found = tests_found(findings, intervals_p);
  const Decision decision = decide({findings.detection.false_alarm, found, std::nullopt, {}});
  findings.verdict = decision.verdict;
  findings.detection.p_value = decision.p_value;
  findings.detection.reason = reason_text(decision, found, findings);
  findings.tests = found;
  if (findings.verdict != Verdict::no_mismatch) return;
  findings.located.intervals.clear();
  findings.located.regimes.clear();
  findings.located.frames.clear();
  findings.located.modules.clear();
  findings.located.line_of_action.reset();
}

Investigation investigate(const Ship& ship, const std::shared_ptr<const EnsembleSimulator>& ensemble,
                          std::vector<Trajectory>& recordings, const GapLocateOptions& options) {
  Investigator investigator(ship, ensemble, recordings, options);
  investigator.check_conventions();
  investigator.audit_sensors();
  investigator.fit();
  investigator.withdraw_faint_faults();
  investigator.identify_faults();
  investigator.refine_faults();
  investigator.test_effects();
  investigator.reread_wind();

  Investigation result = std::move(investigator.result);
  Findings& findings = result.findings;
  if (options.progress) options.progress(0.80, "intervals, frames, regimes");
  LocateOptions locate_options;
  locate_options.false_alarm = options.false_alarm;
  locate_options.jobs = options.jobs;
  locate_options.seed = options.seed;
  Location location = locate(result.campaign, result.null, locate_options);
  findings.located = std::move(location.located);
  decide_findings(findings, location.scan_p_value);
  findings.residuals = residuals(result.campaign, result.null);
  add_notices(findings, result.campaign);
  if (ensemble) add_ensemble_notices(*ensemble, findings);
  if (options.progress) options.progress(0.97, "parameters far off");
  return result;
}

void count_as_recorded(const Origin& origin, std::vector<Trajectory>& recordings, Findings& findings) {
  count_from(origin, recordings, -1.0);
  findings.notices.push_back(counted_from(origin));
}

}  // namespace

std::optional<Origin> count_from_near(const Ship& ship, std::vector<Trajectory>& recordings) {
  const std::optional<Origin> origin = far_origin(recordings, kPolicy.filter.origin_lengths * ship.particulars.L_pp);
  if (origin) count_from(*origin, recordings);
  return origin;
}

Findings gap_locate(const std::shared_ptr<const EnsembleSimulator>& ensemble, std::vector<Trajectory>& recordings,
                    const GapLocateOptions& options) {
  const std::optional<Origin> origin = count_from_near(ensemble->ship(), recordings);
  Findings findings = investigate(ensemble->ship(), ensemble, recordings, options).findings;
  if (origin) count_as_recorded(*origin, recordings, findings);
  if (options.progress) options.progress(1.0, "done");
  return findings;
}

Findings gap_locate(const Ship& ship, std::vector<Trajectory>& recordings, const GapLocateOptions& options) {
  const std::optional<Origin> origin = count_from_near(ship, recordings);
  Investigation investigation = investigate(ship, recordings, options);
  Findings& findings = investigation.findings;
  if (origin) count_as_recorded(*origin, recordings, findings);
  findings.grossly_inconsistent =
      is_grossly_inconsistent(findings, investigation.campaign, investigation.null, options.jobs);
  if (findings.grossly_inconsistent) findings.notices.insert(findings.notices.begin(), another_ship(ship));
  if (options.progress) options.progress(1.0, "done");
  return std::move(findings);
}

Investigation investigate(const Ship& ship, std::vector<Trajectory>& recordings, const GapLocateOptions& options) {
  return investigate(ship, nullptr, recordings, options);
}

}  // namespace leeway::gap
