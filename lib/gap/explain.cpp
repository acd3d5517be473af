#include "gap/explain.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "gap/before_after.hpp"
#include "gap/comparison.hpp"
#include "gap/selection.hpp"

namespace leeway::gap {
namespace {

constexpr double kNotExcluded = 0.3;  // of the probability: what is not excluded against a hypothesis
constexpr double kPossible = 0.01;    // probability that is worth a word
// Of what is called unknown: how often it is an effect of the catalogue that acts in another form than the catalogue's.
constexpr double kOtherForm = 0.2;
// Intervals of 95 % reach as far as Student's with four degrees of freedom: errors on concealed cases have the median
// of a normal distribution, but its tails (docs/gap-explain.md).
constexpr double kStudent95 = 2.776, kTails = kStudent95 / 1.960;
constexpr double kUnexplained = 0.5;  // of the model error's energy that what is named must take away

// How well a delay can be known [s]: what actuators do between samples is not.
double timing_sd_s(const Campaign& campaign) {
  double sample_s = 0.0;
  for (const Stretch& stretch : campaign.stretches) sample_s = std::max(sample_s, stretch.sample_s);
  return 2.0 * kTimingShare * sample_s;
}

Explained told(const Fitted& fitted, const Fitted& none, const Campaign& campaign) {
  Explained result;
  result.name = fitted.hypothesis.name();
  result.log_evidence = fitted.log_evidence - none.log_evidence;
  result.heldout_gain = fitted.gain;
  result.heldout_gain_sd = fitted.gain_sd;
  result.converged = fitted.fit.report.converged;
  std::vector<std::string> sentences, maneuvers;
  const Coordinates z = coordinates_of(fitted.fit);
  for (const EffectSpan& span : spans_of(fitted.hypothesis)) {
    const FreeEffect& effect = fitted.hypothesis.effects[span.effect];
    result.effects.push_back(effect.name());
    sentences.emplace_back(effect_named(effect.name()).info.sentence);
    maneuvers.emplace_back(effect_named(effect.name()).info.separating_maneuver);
    const Eigen::Index n = effect.size();
    const Eigen::VectorXd mean = z.mean.segment(span.first, span.count);
    const Eigen::MatrixXd covariance =
        fitted.kappa * z.covariance.block(span.first, span.first, span.count, span.count);
    const auto parameters = [&](const std::string& recording, const Eigen::VectorXd& at,
                                const Eigen::MatrixXd& spread) {
      // What was believed before any recording was seen.
      const std::vector<FreeEffect::Parameter> before =
          effect.parameters(Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Identity(n, n));
      const Eigen::MatrixXd of_formula = effect.sd_of_formula(at).cwiseAbs2().asDiagonal();
      const std::vector<FreeEffect::Parameter> after = effect.parameters(at, spread + of_formula);
      const std::vector<FreeEffect::Parameter> tails = effect.parameters(at, kTails * kTails * (spread + of_formula));
      for (std::size_t i = 0; i < after.size(); ++i) {
        const FreeEffect::Parameter& p = after[i];
        ExplainedParameter one{effect.name(), p.name,        recording,     p.estimate,    p.sd,
                               tails[i].low,  tails[i].high, before[i].low, before[i].high};
        if (one.name == "delay_s" || one.name == "lag_s") {
          one.sd = std::hypot(p.sd, timing_sd_s(campaign));
          const double wider = one.sd / std::max(p.sd, 1e-12);
          one.low = std::max(0.0, p.estimate - wider * (p.estimate - one.low));
          one.high = p.estimate + wider * (one.high - p.estimate);
        }
        result.parameters.push_back(one);
      }
    };
    if (effect.name() == kVaryingCurrent) {
      const auto first = fitted.hypothesis.effects.begin() + static_cast<std::ptrdiff_t>(span.effect);
      const std::vector<FreeEffect> courses(first, first + static_cast<std::ptrdiff_t>(span.effects));
      const auto before = current_process(campaign.ship, {}, {}, {}),
                 after = current_process(campaign.ship, courses, mean, covariance);
      for (std::size_t i = 0; i < after.size(); ++i)
        result.parameters.push_back({effect.name(), after[i].name, "", after[i].estimate, after[i].sd, after[i].low,
                                     after[i].high, before[i].low, before[i].high});
      continue;
    }
    if (span.effects == 1) {
      parameters(effect.recording() ? campaign.recordings[*effect.recording()].name : "", mean, covariance);
      continue;
    }
    const auto times = static_cast<Eigen::Index>(span.effects);
    const Eigen::MatrixXd average =
        Eigen::MatrixXd::Identity(n, n).replicate(1, times) / static_cast<double>(span.effects);
    parameters("", average * mean, average * covariance * average.transpose());
    for (Eigen::Index i = 0; i < times; ++i)
      parameters(
          campaign.recordings[*fitted.hypothesis.effects[span.effect + static_cast<std::size_t>(i)].recording()].name,
          mean.segment(i * n, n), covariance.block(i * n, i * n, n, n));
  }
  result.sentence = sentences.empty() ? "Nothing is missing." : fmt::format("{}", fmt::join(sentences, " "));
  result.separating_maneuver = fmt::format("{}", fmt::join(maneuvers, "; "));
  return result;
}

// Model error energy: shares of the three axes in one number, yaw by a radius of gyration.
double energy(const Vec3<double>& sigma_w, double L_pp) {
  const Vec3<double> w = sigma_w.cwiseProduct(Vec3<double>(1.0, 1.0, 0.25 * L_pp));
  return w.squaredNorm();
}

// Terms of the unknown are no more probable, against named effects, than that these do not act in another form.
void limit_unknown(Explanation& explanation) {
  double named = 0.0, unknown = 0.0;
  for (const Explained& hypothesis : explanation.hypotheses)
    if (!hypothesis.effects.empty()) (has_terms(hypothesis.effects) ? unknown : named) += hypothesis.probability;
  const double both = named + unknown;
  if (!(named > 0.0) || unknown <= (1.0 - kOtherForm) * both) return;
  for (Explained& hypothesis : explanation.hypotheses)
    if (!hypothesis.effects.empty())
      hypothesis.probability *=
          has_terms(hypothesis.effects) ? (1.0 - kOtherForm) * both / unknown : kOtherForm * both / named;
}

// Something that the catalogue does not hold, beside what was chosen: as probable as its p-value lets it be. The
// p-value bounds the odds for nothing by -e p ln p (Sellke, Bayarri & Berger 2001, The American Statistician 55,
// 62-71).
void add_unknown(Explanation& explanation, const std::vector<std::string>& beside, double p_value) {
  const double p = std::clamp(p_value, 1e-300, std::exp(-1.0)), odds = -std::exp(1.0) * p * std::log(p);
  double named = 0.0;
  for (const Explained& hypothesis : explanation.hypotheses)
    if (!hypothesis.effects.empty() && hypothesis.effects != beside) named += hypothesis.probability;
  const double left = named > 0.0 ? 1.0 - kOtherForm : 1.0;
  for (Explained& hypothesis : explanation.hypotheses)
    hypothesis.probability *=
        hypothesis.effects.empty() || hypothesis.effects == beside ? left * odds / (1.0 + odds) : kOtherForm / named;
  Explained unknown;
  unknown.effects = beside;
  unknown.effects.push_back("unknown");
  unknown.name = fmt::format("{}", fmt::join(unknown.effects, " + "));
  unknown.probability = left / (1.0 + odds);
  unknown.sentence = "Something acts that the catalogue does not hold.";
  unknown.separating_maneuver = "the maneuvers in which what is left is largest";
  explanation.hypotheses.push_back(std::move(unknown));
}

std::vector<ExplainedParameter> estimates_of(const Fault& fault) {
  std::vector<ExplainedParameter> result;
  for (const Estimate& e : fault.parameters)
    result.push_back({fault.name, e.name, "", e.value, e.sd, e.value - kStudent95 * e.sd, e.value + kStudent95 * e.sd,
                      kMissing, kMissing});
  return result;
}

// Faults of sensors and conventions were settled first and taken out: each hypothesis has them, but that nothing at all
// is wrong.
void add_sensors(Explanation& explanation, const Findings& findings) {
  double all_chance = 0.0;  // that one of them is none
  std::vector<std::string> maneuvers;
  Explained sensors;
  const auto add = [&](const std::string& name, const std::string& sentence, double p_value) {
    explanation.verdict = Verdict::mismatch;
    explanation.p_value = std::min(explanation.p_value, p_value);
    if (std::find(sensors.effects.begin(), sensors.effects.end(), name) == sensors.effects.end()) {
      explanation.chosen.insert(explanation.chosen.begin(), name);
      sensors.effects.insert(sensors.effects.begin(), name);
    }
    sensors.sentence = sensors.sentence.empty() ? sentence : sentence + " " + sensors.sentence;
    all_chance = 1.0 - (1.0 - all_chance) * (1.0 - std::clamp(p_value, 0.0, 1.0));
  };
  for (const Reading& reading : findings.conventions.contradicted) add("convention", reading.sentence, 0.0);
  for (const Fault& fault : findings.audit.faults) {
    add(fault.name, fault.sentence, fault.p_value);
    sensors.log_evidence += fault.heldout_gain;
    sensors.heldout_gain += fault.heldout_gain;
    sensors.heldout_gain_sd = std::hypot(sensors.heldout_gain_sd, fault.heldout_gain_sd);
    for (const ExplainedParameter& p : estimates_of(fault)) sensors.parameters.push_back(p);
    maneuvers.push_back(fault.separating_maneuver);
  }
  if (sensors.effects.empty()) return;
  Explained nothing = *std::find_if(explanation.hypotheses.begin(), explanation.hypotheses.end(),
                                    [](const Explained& hypothesis) { return hypothesis.effects.empty(); });
  nothing.probability = all_chance;
  for (Explained& hypothesis : explanation.hypotheses) {
    hypothesis.probability *= 1.0 - all_chance;
    hypothesis.sentence = hypothesis.effects.empty() ? sensors.sentence : sensors.sentence + " " + hypothesis.sentence;
    hypothesis.effects.insert(hypothesis.effects.begin(), sensors.effects.begin(), sensors.effects.end());
    hypothesis.name = fmt::format("{}", fmt::join(hypothesis.effects, " + "));
    hypothesis.log_evidence += sensors.log_evidence;
    hypothesis.heldout_gain += sensors.heldout_gain;
    hypothesis.heldout_gain_sd = std::hypot(hypothesis.heldout_gain_sd, sensors.heldout_gain_sd);
    hypothesis.parameters.insert(hypothesis.parameters.begin(), sensors.parameters.begin(), sensors.parameters.end());
    if (!hypothesis.separating_maneuver.empty()) maneuvers.push_back(hypothesis.separating_maneuver);
    hypothesis.separating_maneuver = fmt::format("{}", fmt::join(maneuvers, "; "));
    maneuvers.resize(findings.audit.faults.size());
  }
  explanation.hypotheses.push_back(std::move(nothing));
}

// Each hypothesis again with another fault in the place of one that these recordings do not tell from it; the
// probability is shared as they predict what was left out, but the fault that was taken out keeps the largest share.
void add_rivals(Explanation& explanation, const Findings& findings) {
  for (const Fault& fault : findings.audit.faults) {
    std::map<std::string, const Fault*> rivals;  // the best of each name
    for (const Fault& rival : fault.rivals)
      if (std::exp(rival.log_odds) > kPossible) rivals.emplace(rival.name, &rival);
    double largest_share = 0.0;
    for (std::size_t h = 0, n = explanation.hypotheses.size(); h < n; ++h) {
      const Explained with = explanation.hypotheses[h];
      const auto has = [&](const std::string& name) {
        return std::find(with.effects.begin(), with.effects.end(), name) != with.effects.end();
      };
      if (!has(fault.name) || with.probability < kPossible) continue;
      double weights = 1.0;
      for (const auto& [name, rival] : rivals)
        if (!has(name)) weights += std::exp(std::min(rival->log_odds, 0.0));
      explanation.hypotheses[h].probability /= weights;
      largest_share = std::max(largest_share, 1.0 / weights);
      for (const auto& [name, rival] : rivals) {
        if (has(name)) continue;
        Explained other = with;
        other.probability *= std::exp(std::min(rival->log_odds, 0.0)) / weights;
        std::replace(other.effects.begin(), other.effects.end(), fault.name, name);
        other.name = fmt::format("{}", fmt::join(other.effects, " + "));
        other.log_evidence += rival->log_odds;
        other.heldout_gain += rival->heldout_gain - fault.heldout_gain;
        std::erase_if(other.parameters, [&](const ExplainedParameter& p) { return p.effect == fault.name; });
        const std::vector<ExplainedParameter> of_rival = estimates_of(*rival);
        other.parameters.insert(other.parameters.begin(), of_rival.begin(), of_rival.end());
        const auto retell = [](std::string& text, const std::string& from, const std::string& to) {
          if (const std::size_t at = text.find(from); at != std::string::npos) text.replace(at, from.size(), to);
        };
        retell(other.sentence, fault.sentence, rival->sentence);
        retell(other.separating_maneuver, fault.separating_maneuver, rival->separating_maneuver);
        explanation.hypotheses.push_back(std::move(other));
      }
    }
    if (largest_share > 0.0) explanation.p_right *= largest_share;
  }
}

// All hypotheses with their probabilities, and the maneuvers that would tell them apart.
void tell_hypotheses(Explanation& explanation, const Comparison& comparison, Campaign& campaign,
                     const GapExplainOptions& options) {
  const std::vector<Fitted>& all = comparison.all();
  for (const Fitted& fitted : all) explanation.hypotheses.push_back(told(fitted, all.front(), campaign));
  const std::vector<double> probabilities = comparison.probabilities();
  for (std::size_t i = 0; i < all.size(); ++i) explanation.hypotheses[i].probability = probabilities[i];
  limit_unknown(explanation);

  std::vector<const Fitted*> possible;
  std::vector<double> weight;
  const double most = *std::max_element(probabilities.begin(), probabilities.end());
  for (std::size_t i = 0; i < all.size(); ++i)
    if (probabilities[i] > std::max(kNotExcluded * most, kPossible)) {
      possible.push_back(&all[i]);
      weight.push_back(probabilities[i]);
    }
  explanation.p_right = most;
  if (possible.size() < 2) return;
  if (options.locate.progress) options.locate.progress(0.88, "which maneuver would tell");
  explanation.next = next_maneuvers(campaign, possible, weight, options.locate.jobs, options.locate.seed);
}

// The verdict, and what is claimed.
void conclude(Explanation& explanation, const Findings& findings, const Comparison& comparison,
              const Selection& selection, const GapExplainOptions& options, double L_pp) {
  const auto [chosen, best, left_p] = std::tie(selection.chosen, selection.best, selection.left_p_value);
  const bool is_named = chosen != 0, errs = selection.error >= kErrorOfForms;
  const double detected_p = findings.detection.p_value, rate = options.locate.false_alarm;
  Verdict& verdict = explanation.verdict;
  verdict = is_named ? Verdict::mismatch : findings.verdict;
  explanation.p_value = detected_p;
  explanation.left_p_value = left_p;
  // Where nothing is missing, odds of so much are no more frequent than that (Markov's inequality).
  if (is_named) explanation.p_value = std::min(detected_p, std::exp(-comparison.log_odds(best)));
  const bool is_likelier = selection.stated[best] > selection.stated[0];
  // Seen, but barely, and nothing missing is the likeliest, or too little to be called unknown: neither claimed nor
  // denied.
  if (verdict == Verdict::mismatch && !is_named && (!errs || detected_p >= surely(options)))
    verdict = Verdict::undecided;
  // Likelier than nothing, but not shown.
  if (verdict == Verdict::no_mismatch && is_likelier) verdict = Verdict::undecided;
  if (verdict != Verdict::mismatch || (!is_named && detected_p >= rate)) return;

  const Fitted& answer = comparison.all()[chosen];
  const double taken = 1.0 - energy(answer.fit.noise.sigma_w, L_pp) / energy(findings.fit.sigma_w, L_pp);
  explanation.is_complete = is_named && (left_p >= rate || selection.is_negligible);
  if (is_named && (explanation.is_complete || !errs || taken > kUnexplained || comparison.log_odds(chosen) > kStrong))
    explanation.chosen = answer.hypothesis.names();
  if (explanation.chosen.empty() && left_p >= surely(options)) {
    verdict = Verdict::undecided;
    return;
  }
  if (explanation.is_complete || !errs || has_terms(explanation.chosen) ||
      (!explanation.chosen.empty() && left_p >= surely_beside(options)))
    return;
  explanation.chosen.push_back("unknown");
  const std::vector<std::string> fitted = answer.hypothesis.names();  // with terms for it, or without
  if (!has_terms(fitted)) add_unknown(explanation, fitted, left_p);
}

// Most probable first, each with those that it is not told from.
void compare_hypotheses(Explanation& explanation) {
  std::stable_sort(explanation.hypotheses.begin(), explanation.hypotheses.end(),
                   [](const Explained& a, const Explained& b) { return a.probability > b.probability; });
  for (Explained& hypothesis : explanation.hypotheses)
    for (const Explained& other : explanation.hypotheses)
      if (&other != &hypothesis && other.probability > std::max(kNotExcluded * hypothesis.probability, kPossible))
        hypothesis.confusable_with.push_back(other.name);
}

}  // namespace

Explanation gap_explain(const Ship& ship, std::vector<Trajectory>& recordings, std::vector<Trajectory>& heldout,
                        const GapExplainOptions& options) {
  const auto progress = [&](double done, const std::string& note) {
    if (options.locate.progress) options.locate.progress(done, note);
  };
  Explanation explanation;
  if (!heldout.empty()) prepare(ship, heldout, {options.locate.step_s, 0.0});  // refused before the long work
  GapLocateOptions locate_options = options.locate;
  locate_options.progress = [&](double done, const std::string& note) { progress(0.4 * done, note); };
  Investigation investigation = investigate(ship, recordings, locate_options);
  Findings& findings = investigation.findings;
  Campaign& campaign = investigation.campaign;

  progress(0.4, "fits with the likeliest effects");
  Comparison comparison(
      campaign, investigation.null,
      {options.locate.false_alarm, options.locate.jobs, findings.detection.p_value > surely_beside(options)});
  const Selection selection = select(campaign, findings, comparison, options);
  tell_hypotheses(explanation, comparison, campaign, options);
  conclude(explanation, findings, comparison, selection, options, ship.particulars.L_pp);
  add_sensors(explanation, findings);
  add_rivals(explanation, findings);
  compare_hypotheses(explanation);
  const Fitted& answer = comparison.all()[selection.chosen];
  explanation.parameters = answer.fit.report.parameters;
  if (std::find(explanation.chosen.begin(), explanation.chosen.end(), kVaryingCurrent) != explanation.chosen.end()) {
    const Coordinates z = coordinates_of(answer.fit);
    explanation.current_paths = current_paths(campaign, answer.hypothesis, z.mean, answer.kappa * z.covariance);
  }
  show_before_after({ship, campaign, findings, investigation.null, comparison, answer, options}, heldout, explanation);

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
