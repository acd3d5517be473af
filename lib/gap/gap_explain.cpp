#include "gap/gap_explain.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <numeric>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "dynamics/run_notices.hpp"
#include "dynamics/straight_run.hpp"
#include "gap/bootstrap/reliability.hpp"
#include "gap/bootstrap/simulated_recordings.hpp"
#include "gap/compare/current_course.hpp"
#include "gap/compare/selection.hpp"
#include "gap/compare/terms.hpp"
#include "gap/decide/found.hpp"
#include "gap/gap_locate.hpp"
#include "gap/report/notices.hpp"
#include "gap/report/reasons.hpp"
#include "gap/sensors/channel_quality.hpp"
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
  const bool are_forms = selection.error < kPolicy.decide.error_of_forms;
  const auto is_of_forms = [&](std::size_t i) {
    return are_forms && has_terms(comparison.all()[i].hypothesis.names());
  };
  found.chance_of_best = comparison.chance_of(selection.best);
  found.best_is_likelier_than_not =
      selection.best != 0 && selection.stated[selection.best] > kPolicy.compare.likelier_than_not;
  found.best_is_significant = comparison.is_significant(selection.best);
  found.is_latent = selection.is_latent;
  // What other forms of her own forces leave as well says nothing against nothing missing.
  if (selection.is_latent || !are_forms)
    found.chance_of_latent = std::exp(-std::max(0.0, selection.latent_log_evidence));
  found.log_odds_of_chosen = comparison.log_odds(selection.chosen);
  for (std::size_t i = 1; i < selection.stated.size(); ++i) {
    found.is_likelier_than_not |= selection.stated[i] > kPolicy.compare.likelier_than_not && !is_of_forms(i);
    if (is_of_forms(i) && selection.stated[i] > selection.stated[selection.best]) found.chance_of_best = 1.0;
  }
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

// The verdict, and what is claimed. Whether it is among names that a maneuver might distinguish.
bool decide_explanation(Explanation& explanation, const Findings& findings, const Comparison& comparison,
                        const Selection& selection, double false_alarm, double L_pp) {
  Found found{false_alarm, findings.tests, std::nullopt, sensors_found(findings)};
  if (!explanation.calibration) found.hypotheses = hypotheses_found(comparison, selection, findings.fit, L_pp);
  // What gap-locate's fit had not reached may be reached by going on with it.
  found.tests.converged |= comparison.none().fit.report.converged;
  const Decision decision = decide(found);
  explanation.verdict = decision.verdict;
  explanation.p_value = decision.p_value;
  if (decision.verdict == Verdict::undecided)
    explanation.reason = reason_text(decision, found.tests, findings, explanation.hypotheses);
  explanation.left_p_value = selection.left_p_value;
  explanation.is_complete = decision.is_complete;
  const std::vector<std::string> fitted = comparison.all()[selection.chosen].hypothesis.names();
  explanation.unknown_kinds = selection.latent;
  if (decision.claims_sensors) explanation.chosen = sensors_claimed(findings);
  if (decision.claims_names) explanation.chosen.insert(explanation.chosen.end(), fitted.begin(), fitted.end());
  if (!decision.claims_unknown) return true;
  explanation.chosen.push_back(name_of_terms());
  if (has_terms(fitted)) return true;  // it is there already
  const bool is_latent = selection.is_latent && !decision.claims_names;
  add_unknown(explanation, fitted,
              is_latent ? std::exp(-selection.latent_log_odds) : least_odds_of_nothing(selection.left_p_value));
  if (!is_latent) return true;
  explanation.p_right = explanation.hypotheses.back().probability;
  return false;
}

// All until probabilities are stated: what simulated campaigns go through again.
struct Analysis {
  Investigation investigation;
  Comparison comparison;  // of the campaign above
  Selection selection;
  Explanation explanation = {};
  std::vector<double> stated = {};  // of the comparison's hypotheses, before sensors share in them
  bool may_plan = true;             // whether maneuvers might distinguish names

  Analysis(const Ship& ship, std::vector<Trajectory>& recordings, const GapExplainOptions& options)
      : investigation(investigate(ship, recordings, in_first_part(options))),
        comparison(investigation.campaign, investigation.null,
                   {options.locate.false_alarm, options.locate.jobs, options.locate.seed,
                    investigation.findings.detection.p_value > surely_beside(options.locate.false_alarm)}),
        selection(select(options)) {
    const Findings& findings = investigation.findings;
    if (options.calibrates) explanation.calibration.emplace();
    report_hypotheses(explanation, comparison, selection.chosen, investigation.campaign);
    for (const Explained& hypothesis : explanation.hypotheses) stated.push_back(hypothesis.probability);
    may_plan = decide_explanation(explanation, findings, comparison, selection, options.locate.false_alarm,
                                  ship.particulars.L_pp);
    say_kind_of_unknown(explanation);
    add_sensors(explanation, findings);
    add_rivals(explanation, findings);
  }
  Analysis(const Analysis&) = delete;  // the comparison refers to the campaign
  Analysis& operator=(const Analysis&) = delete;

 private:
  static GapLocateOptions in_first_part(const GapExplainOptions& options) {
    GapLocateOptions locate = options.locate;
    if (locate.progress)
      locate.progress = [progress = options.locate.progress](double done, const std::string& note) {
        progress(0.4 * done, note);
      };
    return locate;
  }
  Selection select(const GapExplainOptions& options) {
    const auto& progress = options.locate.progress;
    if (progress) progress(0.4, options.calibrates ? "the coefficients" : "fits with the likeliest effects");
    return options.calibrates ? no_selection(investigation.findings)
                              : gap::select(investigation.campaign, investigation.findings, comparison, options);
  }
};

std::vector<double> probabilities_of(const std::vector<Explained>& hypotheses) {
  std::vector<double> result;
  result.reserve(hypotheses.size());
  for (const Explained& hypothesis : hypotheses) result.push_back(hypothesis.probability);
  return result;
}

// What is said of a campaign whose truth is known.
SimulatedAnswer judged(const Analysis& analysis, const Hypothesis& truth) {
  const Explanation& explanation = analysis.explanation;
  SimulatedAnswer result;
  result.truth = truth.names();
  const std::set<std::string> names(result.truth.begin(), result.truth.end());
  result.stated = probabilities_of(explanation.hypotheses);
  const double all = std::accumulate(result.stated.begin(), result.stated.end(), 0.0);
  for (std::size_t i = 0; i < result.stated.size(); ++i) {
    const std::vector<std::string>& effects = explanation.hypotheses[i].effects;
    const bool is_truth = std::set<std::string>(effects.begin(), effects.end()) == names;
    const double p = result.stated[i] /= all;
    if (is_truth) result.stated_of_truth += p;
    if (p <= result.stated_of_first) continue;
    result.stated_of_first = p;
    result.truth_is_first = is_truth;
  }
  result.verdict = explanation.verdict;
  result.alarms = explanation.verdict == Verdict::mismatch;
  result.truth_is_claimed = result.alarms == !names.empty() &&
                            std::set<std::string>(explanation.chosen.begin(), explanation.chosen.end()) == names;
  return result;
}

// Simulates campaigns from what is stated, as probable as that, and analyzes each by the same rules.
Bootstrap bootstrapped(const Ship& ship, const Analysis& analysis, const GapExplainOptions& options,
                       const std::function<void()>& one_more) {
  GapExplainOptions alone = options;
  alone.campaigns = 0;
  alone.locate.jobs = 1;
  alone.locate.progress = nullptr;
  std::vector<std::optional<SimulatedAnswer>> answers(options.campaigns);
  std::mutex one_at_a_time;
  parallel_for(options.campaigns, options.locate.jobs, [&](std::size_t c) {
    RandomStream random(options.locate.seed, "bootstrap", c);
    const double all = std::accumulate(analysis.stated.begin(), analysis.stated.end(), 0.0);
    double left = random.uniform() * all;
    std::size_t truth = 0;
    while (truth + 1 < analysis.stated.size() && (left -= analysis.stated[truth]) >= 0.0) ++truth;
    const Fitted& fitted = analysis.comparison.all()[truth];
    try {
      std::vector<Trajectory> recordings = simulated_recordings(analysis.investigation.campaign, fitted, random);
      answers[c] = judged(Analysis(ship, recordings, alone), fitted.hypothesis);
    } catch (const NumericalError&) {  // counted as failed
    } catch (const InputError&) {
    }
    const std::scoped_lock lock(one_at_a_time);
    one_more();
  });
  Bootstrap result;
  for (std::optional<SimulatedAnswer>& answer : answers)
    if (answer)
      result.campaigns.push_back(std::move(*answer));
    else
      ++result.failed;
  if (result.campaigns.empty())
    throw NumericalError(
        fmt::format("none of {} campaigns like these could be simulated and analyzed", options.campaigns));
  fit_reliability(result);
  return result;
}

// The probabilities of the report as the bootstrap makes them.
void take_as_realized(const Bootstrap& bootstrap, Analysis& analysis) {
  std::vector<Explained>& hypotheses = analysis.explanation.hypotheses;
  const std::vector<double> probabilities = as_realized(bootstrap, probabilities_of(hypotheses));
  for (std::size_t i = 0; i < hypotheses.size(); ++i) hypotheses[i].probability = probabilities[i];
  analysis.explanation.p_right = *std::ranges::max_element(probabilities);
  analysis.stated = as_realized(bootstrap, std::move(analysis.stated));
}

}  // namespace

Explanation gap_explain(const Ship& ship, std::vector<Trajectory>& recordings, std::vector<Trajectory>& heldout,
                        const GapExplainOptions& given) {
  // Simulated campaigns take nearly all of the time where they are asked for.
  const double of_campaigns = static_cast<double>(given.campaigns) / static_cast<double>(given.locate.jobs),
               own_share = 1.0 / (1.0 + of_campaigns);
  double before = 0.0;  // share that is done of what is not its own
  const auto progress = [&](double done, const std::string& note) {
    if (given.locate.progress) given.locate.progress(before + own_share * done, note);
  };
  GapExplainOptions options = given;
  options.locate.progress = progress;
  const std::optional<Origin> origin = count_from_near(ship, recordings);
  if (origin) count_from(*origin, heldout);
  for (const Trajectory& held : heldout)
    for (const Trajectory& recording : recordings)
      if (same_contents(held, recording))
        throw InputError(held.file, fmt::format("holds the same as {}: what is fitted judges nothing", recording.file));
  add_revolutions(heldout, ship);
  if (!heldout.empty()) prepare(ship, heldout, {options.locate.step_s, 0.0});  // refused before the long work
  Analysis analysis(ship, recordings, options);
  Findings& findings = analysis.investigation.findings;
  Explanation& explanation = analysis.explanation;
  const Campaign& campaign = analysis.investigation.campaign;
  const Comparison& comparison = analysis.comparison;
  const Selection& selection = analysis.selection;
  if (options.campaigns > 0) {
    const double each = (1.0 - own_share) / static_cast<double>(options.campaigns);
    std::size_t done = 0;
    explanation.bootstrap = bootstrapped(ship, analysis, options, [&] {
      before += each;
      progress(0.88, fmt::format("campaign {} of {}, simulated and analyzed", ++done, options.campaigns));
    });
    take_as_realized(*explanation.bootstrap, analysis);
  }
  if (analysis.may_plan && !options.calibrates) plan_next(explanation, comparison, analysis.stated, campaign, options);
  sort_hypotheses(explanation);
  const Fitted& answer = comparison.all()[selection.chosen];
  explanation.parameters = answer.fit.report.parameters;
  if (std::any_of(explanation.chosen.begin(), explanation.chosen.end(),
                  [](const std::string& name) { return search_start(name) == SearchStart::course; })) {
    const Coordinates z = coordinates_of(answer.fit);
    explanation.current_paths = current_paths(campaign, answer.hypothesis, z.mean, answer.kappa * z.covariance);
  }
  const Answered answered{ship, campaign, findings, analysis.investigation.null, comparison, answer, options};
  show_before_after(answered, heldout, explanation);
  progress(0.96, "modules of the ship file, one by one");
  explanation.ship_file = judge_ship_file(answered, explanation);
  if (options.calibrates) finish_calibration(explanation, answer.fit);
  explanation.beyond_recorded = turning_beyond_recorded(answered, explanation);
  explanation.n_rps = revolutions_of(ship, explanation);

  findings.grossly_inconsistent = errs_grossly(answer.fit.report);
  for (const ChannelQuality& quality : findings.audit.channels)
    if (quality.frozen_share > 0.0) findings.notices.push_back(frozen_text(quality));
  if (origin) findings.notices.push_back(counted_from(*origin));
  explanation.notices.insert(explanation.notices.begin(), findings.notices.begin(), findings.notices.end());
  if (!selection.unexcited.empty())
    explanation.notices.push_back(
        fmt::format("not tried, since these recordings cannot show it: {}", fmt::join(selection.unexcited, ", ")));
  explanation.findings = std::move(findings);
  progress(1.0, "done");
  return std::move(explanation);
}

}  // namespace leeway::gap
