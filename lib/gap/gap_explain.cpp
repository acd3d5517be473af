#include "gap/gap_explain.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "dynamics/run_notices.hpp"
#include "dynamics/straight_run.hpp"
#include "gap/compare/current_course.hpp"
#include "gap/compare/selection.hpp"
#include "gap/compare/terms.hpp"
#include "gap/decide/found.hpp"
#include "gap/gap_locate.hpp"
#include "gap/show/before_after.hpp"
#include "gap/show/beyond_recorded.hpp"
#include "gap/show/hypotheses.hpp"
#include "gap/show/ship_file.hpp"
#include "ship/pitch_current.hpp"

namespace leeway::gap {
namespace {

// Model error energy: shares of the three axes in one number, yaw by a radius of gyration.
double energy(const Vec3<double>& sigma_w, double L_pp) {
  const Vec3<double> w = sigma_w.cwiseProduct(Vec3<double>(1.0, 1.0, kPolicy.detect.gyration_radius_per_L * L_pp));
  return w.squaredNorm();
}

// What the comparison found, for the decision.
HypothesesFound hypotheses_found(const Comparison& comparison, const Selection& selection, const NullFit& null,
                                 double L_pp) {
  const Fitted& answer = comparison.all()[selection.chosen];
  HypothesesFound found;
  found.is_named = selection.chosen != 0;
  found.has_terms = has_terms(answer.hypothesis.names());
  found.chance_of_best = comparison.chance_of(selection.best);
  found.is_latent = selection.is_latent;
  found.chance_of_latent = std::exp(-std::max(0.0, selection.latent_log_odds));
  found.log_odds_of_chosen = comparison.log_odds(selection.chosen);
  for (std::size_t i = 1; i < selection.stated.size(); ++i)
    found.is_likelier |=
        selection.stated[i] > selection.stated[0] &&
        (selection.error >= kPolicy.decide.error_of_forms || !has_terms(comparison.all()[i].hypothesis.names()));
  found.left_p = selection.left_p_value;
  found.is_negligible = selection.is_negligible;
  found.error_share = selection.error;
  found.taken_share = 1.0 - energy(answer.fit.noise.sigma_w, L_pp) / energy(null.sigma_w, L_pp);
  return found;
}

// Revolutions that hold the usual speed of ship.json, where those of the ship file would not.
std::optional<double> revolutions_of(Ship ship, const Explanation& explanation) {
  ship.multiply(explanation.coefficient_factors);
  ship.effects.insert(ship.effects.end(), explanation.effects.begin(), explanation.effects.end());
  try {
    if (ship.propulsion().empty() || !speed_notice(ship, ship.u0_mps, ship.propulsion().front().initial))
      return std::nullopt;
    return self_propulsion_n(ship, ship.u0_mps);
  } catch (const NumericalError&) {
    return std::nullopt;
  }
}

// Nothing is named; how much the simulator errs then is what gap-locate found.
Selection no_selection(const Findings& findings) {
  Selection selection;
  selection.stated = {1.0};
  selection.left_p_value = findings.detection.p_value;
  return selection;
}

// What a posterior is worth. No hypotheses, of which none was asked for; and no likelihoods and coverage before, since
// what was fitted with nothing missing is what comes after.
void finish_calibration(Explanation& explanation, const FittedNull& fit) {
  for (Scores* before : {&explanation.train.before, &explanation.heldout.before}) {
    before->log_likelihood_per_sample = kMissing;
    before->coverage.clear();
  }
  explanation.is_complete = explanation.verdict != Verdict::mismatch;
  explanation.hypotheses.clear();
  explanation.p_right = kMissing;
  if (!fit.report.converged)
    explanation.notices.emplace_back(
        "the fit has not converged: neither the coefficients nor coefficient_covariance can be trusted");
  if (explanation.verdict == Verdict::mismatch && explanation.chosen.empty())
    explanation.notices.emplace_back(
        "the coefficients stand in for something else that is missing: what coefficient_covariance leaves open holds "
        "only if nothing is");
  if (fit.scale > 1.0)
    explanation.notices.push_back(fmt::format(
        "the coefficients are likeliest {:.2g} times as uncertain as the ship file states: all its standard "
        "deviations are taken so much wider",
        fit.scale));
}

// The verdict, and what is claimed.
void decide_explanation(Explanation& explanation, const Findings& findings, const Comparison& comparison,
                        const Selection& selection, double false_alarm, double L_pp) {
  std::optional<HypothesesFound> hypotheses;
  if (!explanation.calibration) hypotheses = hypotheses_found(comparison, selection, findings.fit, L_pp);
  const Decision decision = decide({false_alarm, findings.tests, hypotheses, sensors_found(findings)});
  explanation.verdict = decision.verdict;
  explanation.p_value = decision.p_value;
  explanation.left_p_value = selection.left_p_value;
  explanation.is_complete = decision.is_complete;
  const std::vector<std::string> fitted = comparison.all()[selection.chosen].hypothesis.names();
  explanation.unknown_kinds = selection.latent;
  if (decision.claims_sensors) explanation.chosen = sensors_claimed(findings);
  if (decision.claims_names) explanation.chosen.insert(explanation.chosen.end(), fitted.begin(), fitted.end());
  if (!decision.claims_unknown) return;
  explanation.chosen.push_back(name_of_terms());
  if (has_terms(fitted)) return;  // it is there already
  const bool is_latent = selection.is_latent && !decision.claims_names;
  add_unknown(explanation, fitted,
              is_latent ? std::exp(-selection.latent_log_odds) : least_odds_of_nothing(selection.left_p_value));
  if (!is_latent) return;
  explanation.next.clear();  // they would distinguish names, of which none is claimed
  explanation.p_right = explanation.hypotheses.back().probability;
}

}  // namespace

Explanation gap_explain(const Ship& ship, std::vector<Trajectory>& recordings, std::vector<Trajectory>& heldout,
                        const GapExplainOptions& options) {
  const auto progress = [&](double done, const std::string& note) {
    if (options.locate.progress) options.locate.progress(done, note);
  };
  Explanation explanation;
  add_revolutions(heldout, ship);
  if (!heldout.empty()) prepare(ship, heldout, {options.locate.step_s, 0.0});  // refused before the long work
  GapLocateOptions locate_options = options.locate;
  locate_options.progress = [&](double done, const std::string& note) { progress(0.4 * done, note); };
  Investigation investigation = investigate(ship, recordings, locate_options);
  Findings& findings = investigation.findings;
  const Campaign& campaign = investigation.campaign;

  if (options.calibrates) explanation.calibration.emplace();
  progress(0.4, options.calibrates ? "the coefficients" : "fits with the likeliest effects");
  const double rate = options.locate.false_alarm;
  Comparison comparison(
      campaign, investigation.null,
      {rate, options.locate.jobs, options.locate.seed, findings.detection.p_value > surely_beside(rate)});
  const Selection selection =
      options.calibrates ? no_selection(findings) : select(campaign, findings, comparison, options);
  report_hypotheses(explanation, comparison, selection.chosen, campaign, options);
  decide_explanation(explanation, findings, comparison, selection, rate, ship.particulars.L_pp);
  say_kind_of_unknown(explanation);
  add_sensors(explanation, findings);
  add_rivals(explanation, findings);
  sort_hypotheses(explanation);
  const Fitted& answer = comparison.all()[selection.chosen];
  explanation.parameters = answer.fit.report.parameters;
  if (std::any_of(explanation.chosen.begin(), explanation.chosen.end(),
                  [](const std::string& name) { return search_start(name) == SearchStart::course; })) {
    const Coordinates z = coordinates_of(answer.fit);
    explanation.current_paths = current_paths(campaign, answer.hypothesis, z.mean, answer.kappa * z.covariance);
  }
  const Answered answered{ship, campaign, findings, investigation.null, comparison, answer, options};
  show_before_after(answered, heldout, explanation);
  progress(0.96, "modules of the ship file, one by one");
  explanation.ship_file = judge_ship_file(answered, explanation);
  if (options.calibrates) finish_calibration(explanation, answer.fit);
  explanation.beyond_recorded = turning_beyond_recorded(answered, explanation);
  explanation.n_rps = revolutions_of(ship, explanation);

  findings.grossly_inconsistent = errs_grossly(answer.fit.report);
  explanation.notices.insert(explanation.notices.begin(), findings.notices.begin(), findings.notices.end());
  if (!selection.unexcited.empty())
    explanation.notices.push_back(
        fmt::format("not tried, since these recordings cannot show it: {}", fmt::join(selection.unexcited, ", ")));
  explanation.findings = std::move(findings);
  progress(1.0, "done");
  return explanation;
}

}  // namespace leeway::gap
