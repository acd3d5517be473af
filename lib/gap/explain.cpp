#include "gap/explain.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "gap/comparison.hpp"
#include "gap/free_runs.hpp"
#include "gap/learned_residual.hpp"
#include "gap/locate.hpp"
#include "gap/words.hpp"

namespace leeway::gap {
namespace {

constexpr std::size_t kAlwaysRefitted = 3;
constexpr std::size_t kNextRefitted = 4;  // beside what was chosen
constexpr double kHopeless = 0.5;         // of the evidence that was gained: what promises less is not fitted any more,
constexpr double kHopelessOfPlaces = 0.8;  // they are many, and a step towards the best of many promises too much
constexpr double kFarBehind = 20.0;        // if it is so many nats behind
constexpr double kPairGain = 10.0;         // nats by which a pair must promise more than one effect
constexpr double kNotExcluded = 0.3;       // of the probability: what is not excluded against a hypothesis
constexpr double kPossible = 0.01;         // probability that is worth a word
constexpr double kUnexplained = 0.5;       // of the model error's energy that what is named must take away
constexpr double kErrorOfForms = 0.1;      // of the typical acceleration: what simulators leave that lack nothing
constexpr double kStrong = 5.7;            // nats of posterior odds: then the p-value is not asked
constexpr double kOfPlaces = 5.0;     // nats for a residual that depends on the position: walls and lines are tried
constexpr double kSameFactor = 1e-3;  // of a coefficient: what is nearer to 1 is not written down
constexpr double kNegligible = 0.05;  // of the evidence of what is named: what is left is not worth a word

// The p-value of what is left beside a hypothesis: effects of the catalogue around its fit, and intervals.
double left_beside(const Campaign& campaign, const Fitted& fitted, const GapExplainOptions& options) {
  const Coordinates z = coordinates_of(fitted.fit);
  Campaign with = campaign;
  for (std::size_t r = 0; r < campaign.recordings.size(); ++r) {
    const Ship there = fitted.hypothesis.applied_to(campaign.ship, z.mean, r);
    with.own_effects[r].assign(there.effects.begin() + static_cast<std::ptrdiff_t>(campaign.ship.effects.size()),
                               there.effects.end());
  }
  FittedNull fit = fitted.fit;
  for (std::size_t s = 0; s < with.stretches.size(); ++s) {
    const std::size_t r = with.stretches[s].recording;
    const RudderResponse response = Effects<double>(with.ship_in(r)).rudder_response();
    if (response != Effects<double>(campaign.ship).rudder_response())
      set_inputs(with.stretches[s], with.recorded_inputs[r].through(response), with.ship);
    fit.stretches[s].data = &with.stretches[s];
  }
  const EffectLibrary library(with, fit);
  DetectOptions detect_options;
  detect_options.false_alarm = options.locate.false_alarm;
  detect_options.jobs = options.locate.jobs;
  detect_options.seed = options.locate.seed;
  detect_options.refitted = 3;
  LocateOptions locate_options;
  locate_options.false_alarm = options.locate.false_alarm;
  locate_options.jobs = options.locate.jobs;
  locate_options.seed = options.locate.seed;
  return std::min(1.0, 2.0 * std::min(detect(with, fit, library, detect_options).p_value,
                                      strongest_interval(with, fit, locate_options)));
}

// How well a delay can be known [s]: what actuators do between samples is not.
double timing_sd_s(const Campaign& campaign) {
  double sample_s = 0.0;
  for (const Stretch& stretch : campaign.stretches) sample_s = std::max(sample_s, stretch.sample_s);
  return 2.0 * kTimingShare * sample_s;
}

// Whether terms stand for what the catalogue does not hold.
bool has_terms(const std::vector<std::string>& names) {
  return std::find(names.begin(), names.end(), "unknown") != names.end();
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
      const std::vector<FreeEffect::Parameter> after = effect.parameters(at, spread);
      for (std::size_t i = 0; i < after.size(); ++i) {
        const FreeEffect::Parameter& p = after[i];
        ExplainedParameter one{effect.name(), p.name, recording,     p.estimate,    p.sd,
                               p.low,         p.high, before[i].low, before[i].high};
        if (one.name == "delay_s" || one.name == "lag_s") {
          one.sd = std::hypot(p.sd, timing_sd_s(campaign));
          const double wider = one.sd / std::max(p.sd, 1e-12);
          one.low = std::max(0.0, p.estimate - wider * (p.estimate - p.low));
          one.high = p.estimate + wider * (p.high - p.estimate);
        }
        result.parameters.push_back(one);
      }
    };
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

// The interval as a tug of unknown force, direction and point of action.
FreeEffect::Choice tug_in(const Interval& interval, const Campaign& campaign) {
  FreeEffect::Choice tug;
  tug.fixed = {{"t_start_s", interval.t_start_s}, {"t_end_s", interval.t_end_s}};
  tug.freed = {"x_m"};
  tug.log_ways = std::log(static_cast<double>(interval.searched));
  for (std::size_t r = 0; r < campaign.recordings.size() && campaign.recordings.size() > 1; ++r)
    if (campaign.recordings[r].file == interval.file) tug.recording = r;
  return tug;
}

// A fit whose effects stand in the ship now.
FittedNull with_effects_in_ship(FittedNull fit) {
  fit.theta = without_effects(fit.theta, fit.effects);
  fit.prior_sd = without_effects(fit.prior_sd, fit.effects);
  fit.parameters.erase(fit.parameters.end() - 1 - fit.effects, fit.parameters.end() - 1);
  fit.effects = 0;
  return fit;
}

std::vector<EffectEntry> added(const Ship& with, const Ship& to) {
  return {with.effects.begin() + static_cast<std::ptrdiff_t>(to.effects.size()), with.effects.end()};
}

// The runs of each recording, with the ship as it sails there.
std::vector<ShipOnRuns> by_recording(const Hypothesis& hypothesis, const Eigen::VectorXd& z, const Campaign& campaign,
                                     const std::vector<Run>& runs) {
  if (!hypothesis.differs()) return {{hypothesis.applied_to(campaign.ship, z), runs}};
  std::vector<ShipOnRuns> result;
  for (std::size_t r = 0; r < campaign.recordings.size(); ++r) {
    result.push_back({hypothesis.applied_to(campaign.ship, z, r), {}});
    for (const Run& run : runs)
      if (campaign.stretches[run.stretch].recording == r) result.back().runs.push_back(run);
  }
  return result;
}

// What theta says of the coefficients.
std::vector<CoefficientFactor> factors_of(const FittedNull& fit, const Eigen::VectorXd& theta) {
  std::vector<CoefficientFactor> factors;
  for (Eigen::Index i = 0; i < theta.size() - 1 - fit.effects; ++i)
    if (std::abs(theta[i]) > kSameFactor)
      factors.push_back({fit.parameters[static_cast<std::size_t>(i)].name, std::exp(theta[i])});
  return factors;
}

// Something that the catalogue does not hold, beside what was chosen: as probable as its p-value lets it be. The
// p-value bounds the odds for nothing by -e p ln p (Sellke, Bayarri & Berger 2001, The American Statistician 55,
// 62-71).
void add_unknown(Explanation& explanation, const std::vector<std::string>& beside, double p_value) {
  const double p = std::clamp(p_value, 1e-300, std::exp(-1.0)), odds = -std::exp(1.0) * p * std::log(p);
  for (Explained& hypothesis : explanation.hypotheses) hypothesis.probability *= odds / (1.0 + odds);
  Explained unknown;
  unknown.effects = beside;
  unknown.effects.push_back("unknown");
  unknown.name = fmt::format("{}", fmt::join(unknown.effects, " + "));
  unknown.probability = 1.0 / (1.0 + odds);
  unknown.sentence = "Something acts that the catalogue does not hold.";
  unknown.separating_maneuver = "the maneuvers in which what is left is largest";
  explanation.hypotheses.push_back(std::move(unknown));
}

// Faults of sensors and conventions were settled first and taken out: each hypothesis has them, but that nothing at all
// is wrong.
void add_sensors(Explanation& explanation, const Findings& findings) {
  double all_chance = 0.0;  // that one of them is none
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
    for (const Estimate& e : fault.parameters)
      sensors.parameters.push_back(
          {fault.name, e.name, "", e.value, e.sd, e.value - 1.96 * e.sd, e.value + 1.96 * e.sd, kMissing, kMissing});
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
  }
  explanation.hypotheses.push_back(std::move(nothing));
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
  explanation.p_value = findings.detection.p_value;
  explanation.verdict = findings.verdict;

  progress(0.4, "fits with the likeliest effects");
  Comparison comparison(campaign, investigation.null, {options.locate.false_alarm, options.locate.jobs});
  const bool is_searched = findings.verdict != Verdict::no_mismatch;
  std::size_t best = 0;
  const auto better = [&](std::optional<std::size_t> i) {
    if (i && comparison.log_odds(*i) > comparison.log_odds(best)) best = *i;
  };
  // Fitted one by one, until what comes next promises far less than what was found.
  const auto evidence = [&](std::size_t i) { return comparison.all()[i].log_evidence; };
  const auto is_hopeless = [&](double promised, std::optional<std::size_t> found, std::size_t beside,
                               double share = kHopeless) {
    if (!found) return false;
    const double gained = evidence(*found) - evidence(beside);
    return promised < share * gained && promised < gained - kFarBehind;
  };
  std::vector<std::string> unexcited;
  std::vector<Start> pair;
  const auto first = comparison.promises(0, is_searched ? options.refitted : kAlwaysRefitted, &unexcited,
                                         is_searched ? &pair : nullptr);
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (i >= kAlwaysRefitted && is_hopeless(first[i].gain, best, 0)) break;
    progress(0.45 + 0.25 * static_cast<double>(i) / static_cast<double>(first.size()), "fit with " + first[i].effect);
    better(comparison.add(0, first[i].starts));
  }
  if (!pair.empty() && !first.empty() &&
      pair.front().log_evidence > std::max(first.front().starts.front().log_evidence, evidence(best)) + kPairGain) {
    progress(0.72, "fit with " + pair.front().hypothesis.name());
    better(comparison.add(0, pair));
  }
  // Where something acts at times, or the residual depends on the position, it may be bound to a place.
  const bool acts_at_times =
      !findings.located.intervals.empty() && findings.located.intervals.front().p_value < options.locate.false_alarm;
  const bool is_of_places =
      is_searched &&
      (acts_at_times || errs_grossly(findings.fit) ||
       std::any_of(findings.located.frames.begin(), findings.located.frames.end(),
                   [](const Frame& frame) { return frame.name == "position" && frame.log_evidence > kOfPlaces; }));
  if (is_of_places) {
    progress(0.73, "banks, fenders, moorings");
    for (const auto& promise : comparison.promises_of_places(0))
      if (!is_hopeless(promise.gain, best, 0, kHopelessOfPlaces)) better(comparison.add(0, promise.starts));
  }
  if (is_searched && acts_at_times)
    better(comparison.add(0, comparison.starts_with(0, "tug", tug_in(findings.located.intervals.front(), campaign))));
  if (is_searched) {
    progress(0.74, "terms of what the catalogue does not hold");
    better(comparison.add(0, comparison.terms_beside(0)));
  }
  const auto choice_of = [&](const std::string& effect) {
    return effect == "tug" ? tug_in(findings.located.intervals.front(), campaign) : FreeEffect::Choice();
  };
  // Of all, the one that will be stated as likeliest, if it predicts better what was left out.
  const std::vector<double> stated = comparison.probabilities();
  // Terms are always likelier than nothing where the forms of the forces are not quite those of the ship.
  const double error = findings.fit.sigma_w.cwiseQuotient(findings.fit.typical.cwiseMax(1e-12)).maxCoeff();
  best = 0;
  for (std::size_t i = 1; i < stated.size(); ++i)
    if ((best == 0 || stated[i] > stated[best]) &&
        (error >= kErrorOfForms || !has_terms(comparison.all()[i].hypothesis.names())))
      best = i;
  const bool is_likelier = findings.detection.p_value < options.locate.false_alarm && stated[best] > stated[0];
  const bool is_certain = is_likelier || comparison.log_odds(best) > kStrong;
  std::size_t chosen = is_certain && comparison.holds(best, 0, is_likelier ? 0.0 : 1.0) ? best : 0;
  double left_p = chosen == 0 ? findings.detection.p_value : 1.0;
  // Beside what is named: its own form may be a little other than the catalogue's.
  const double surely = options.locate.false_alarm * options.locate.false_alarm;
  bool is_negligible = false;  // what is left
  while (chosen != 0) {
    const std::size_t size = comparison.all()[chosen].hypothesis.names().size();
    progress(0.75 + 0.04 * static_cast<double>(size),
             "what is left beside " + comparison.all()[chosen].hypothesis.name());
    left_p = left_beside(campaign, comparison.all()[chosen], options);
    if (size >= options.most_effects) break;
    // A p-value is against everything that may be left; one effect can be certain where that is not small.
    const bool is_left = left_p < options.locate.false_alarm;
    std::optional<std::size_t> next;
    for (const auto& promise : comparison.promises(chosen, kNextRefitted)) {
      if (is_hopeless(promise.gain, next, chosen) || (!is_left && promise.gain < kStrong)) break;
      if (const auto added = comparison.add(chosen, promise.starts))
        if (!next || evidence(*added) > evidence(*next)) next = added;
    }
    is_negligible = -std::log(std::max(left_p, 1e-300)) < kNegligible * (evidence(chosen) - evidence(0));
    // Likelier, but not shown to help: not claimed, and no unknown either.
    is_negligible |= left_p >= surely && next && comparison.log_odds(*next) > comparison.log_odds(chosen);
    if (!next || !comparison.holds(*next, chosen, left_p)) break;
    if (!is_left && comparison.log_odds(*next) - comparison.log_odds(chosen) < kStrong) break;
    chosen = *next;
    is_negligible = false;
  }
  // What the catalogue does not hold, in a few terms.
  if (left_p < surely && chosen != 0 && !is_negligible && error >= kErrorOfForms &&
      !has_terms(comparison.all()[chosen].hypothesis.names())) {
    progress(0.86, "terms for what is left");
    const auto added = comparison.add(chosen, comparison.terms_beside(chosen));
    if (added && comparison.holds(*added, chosen, left_p) && comparison.log_odds(*added) > comparison.log_odds(best)) {
      chosen = *added;
      left_p = left_beside(campaign, comparison.all()[chosen], options);
    }
  }
  // One that was taken first may have stood in for two others.
  for (bool is_shorter = chosen != 0; is_shorter;) {
    is_shorter = false;
    const std::vector<std::string> names = comparison.all()[chosen].hypothesis.names();
    if (names.size() < 2 || has_terms(names)) break;
    for (std::size_t out = 0; out < names.size() && !is_shorter; ++out) {
      std::optional<std::size_t> reduced = std::size_t{0};
      for (std::size_t i = 0; i < names.size() && reduced; ++i)
        if (i != out)
          reduced = comparison.add(*reduced, comparison.starts_with(*reduced, names[i], choice_of(names[i])));
      if (reduced && *reduced != 0 && !comparison.holds(chosen, *reduced, 1.0)) {
        chosen = *reduced;
        is_shorter = true;
      }
    }
  }

  const std::vector<Fitted>& all = comparison.all();
  for (const Fitted& fitted : all) explanation.hypotheses.push_back(told(fitted, all.front(), campaign));
  const std::vector<double> probabilities = comparison.probabilities();
  for (std::size_t i = 0; i < all.size(); ++i) explanation.hypotheses[i].probability = probabilities[i];

  std::vector<const Fitted*> possible;
  std::vector<double> weight;
  const double most = *std::max_element(probabilities.begin(), probabilities.end());
  for (std::size_t i = 0; i < all.size(); ++i)
    if (probabilities[i] > std::max(kNotExcluded * most, kPossible)) {
      possible.push_back(&all[i]);
      weight.push_back(probabilities[i]);
    }
  explanation.p_right = most;
  if (possible.size() > 1) {
    progress(0.88, "which maneuver would tell");
    explanation.next = next_maneuvers(campaign, possible, weight, options.locate.jobs, options.locate.seed);
  }

  const Fitted& answer = all[chosen];
  explanation.left_p_value = left_p;
  const bool is_something = chosen != 0 || findings.detection.p_value < options.locate.false_alarm;
  if (chosen != 0) {
    explanation.verdict = Verdict::mismatch;
    // Where nothing is missing, odds of so much are no more frequent than that (Markov's inequality).
    explanation.p_value = std::min(explanation.p_value, std::exp(-comparison.log_odds(best)));
  }
  // Seen, but barely, and nothing missing is the likeliest, or too little to be called unknown: neither claimed nor
  // denied.
  const bool is_barely = stated[best] <= stated[0] && findings.detection.p_value >= surely;
  if (chosen == 0 && (is_barely || error < kErrorOfForms) && explanation.verdict == Verdict::mismatch)
    explanation.verdict = Verdict::undecided;
  // Likelier than nothing, but not shown.
  if (chosen == 0 && stated[best] > stated[0] && explanation.verdict == Verdict::no_mismatch)
    explanation.verdict = Verdict::undecided;
  if (explanation.verdict == Verdict::mismatch && is_something) {
    const double L = ship.particulars.L_pp;
    const double taken = 1.0 - energy(answer.fit.noise.sigma_w, L) / energy(findings.fit.sigma_w, L);
    explanation.is_complete = chosen != 0 && (left_p >= options.locate.false_alarm || is_negligible);
    if (chosen != 0 && (explanation.is_complete || taken > kUnexplained || error < kErrorOfForms ||
                        comparison.log_odds(chosen) > kStrong))
      explanation.chosen = answer.hypothesis.names();
    const auto names = [&](const char* name) {
      return std::find(explanation.chosen.begin(), explanation.chosen.end(), name) != explanation.chosen.end();
    };
    if (!explanation.is_complete && !names("unknown") && error >= kErrorOfForms &&
        (explanation.chosen.empty() || left_p < surely)) {
      explanation.chosen.push_back("unknown");
      const std::vector<std::string> fitted = answer.hypothesis.names();  // with terms for it, or without
      if (!has_terms(fitted)) add_unknown(explanation, fitted, left_p);
    }
  }
  add_sensors(explanation, findings);
  std::stable_sort(explanation.hypotheses.begin(), explanation.hypotheses.end(),
                   [](const Explained& a, const Explained& b) { return a.probability > b.probability; });
  for (Explained& hypothesis : explanation.hypotheses)
    for (const Explained& other : explanation.hypotheses)
      if (&other != &hypothesis && other.probability > std::max(kNotExcluded * hypothesis.probability, kPossible))
        hypothesis.confusable_with.push_back(other.name);
  explanation.parameters = answer.fit.report.parameters;

  const std::size_t jobs = options.locate.jobs;
  const Coordinates z = coordinates_of(answer.fit);
  Ship with = answer.hypothesis.applied_to(campaign.ship, z.mean);
  // Each part that is left out in turn, with what was fitted to the rest: the effects alone, and with the coefficients.
  const Blocks blocks = blocks_of(campaign, answer.fit, answer.fit.noise, {0, nullptr}, jobs);
  const Evidence total = blocks.total();
  std::vector<Eigen::VectorXd> theta_of_fold;
  std::vector<std::vector<Run>> left_out;
  std::vector<ShipOnRuns> as_stated, alone, with_coefficients;
  for (const std::vector<std::size_t>& fold : comparison.folds()) {
    const std::vector<Run>& runs = left_out.emplace_back(runs_of(campaign, blocks, fold));
    const Eigen::VectorXd& theta = theta_of_fold.emplace_back(refitted(answer.fit, without(total, blocks, fold)));
    as_stated.push_back({ship, runs});
    for (ShipOnRuns& one :
         by_recording(answer.hypothesis, theta.segment(theta.size() - 1 - answer.fit.effects, answer.fit.effects),
                      campaign, runs)) {
      with_coefficients.push_back(one);
      with_coefficients.back().ship.multiply(factors_of(answer.fit, theta));
      alone.push_back(std::move(one));
    }
  }
  const std::vector<Smoothed>& starts = investigation.null.smoothed;
  const Scores of_alone = free_runs(campaign, starts, alone, jobs),
               of_coefficients = free_runs(campaign, starts, with_coefficients, jobs);
  const bool takes_coefficients = log_error(of_coefficients) < log_error(of_alone) - kWorthIt &&
                                  is_beyond_chance(campaign, starts, alone, with_coefficients, jobs);
  if (takes_coefficients) explanation.coefficient_factors = factors_of(answer.fit, answer.fit.theta);
  with.multiply(explanation.coefficient_factors);
  LearnedResidual learned;
  if (std::find(explanation.chosen.begin(), explanation.chosen.end(), "unknown") != explanation.chosen.end()) {
    progress(0.89, "a network for what is left");
    if (answer.hypothesis.differs())
      learned.problem = "what is named differs between recordings";
    else if (ship.residual_network)
      learned.problem = "the ship has one already";
    else
      learned = learn_residual(campaign, starts, with, left_out, answer.fit.noise, options.locate.seed, jobs);
    if (!learned.problem.empty()) explanation.notices.push_back("no network learned what is left: " + learned.problem);
    explanation.residual_network = with.residual_network = learned.network;
    explanation.log_error_without_network = learned.log_error_without;
    explanation.log_error_with_network = learned.log_error_with;
  }

  progress(0.9, "free runs before and after");
  explanation.effects = added(with, campaign.ship);
  if (answer.hypothesis.differs())
    for (std::size_t r = 0; r < campaign.recordings.size(); ++r)
      explanation.effects_in[campaign.recordings[r].name] =
          added(answer.hypothesis.applied_to(campaign.ship, z.mean, r), campaign.ship);
  explanation.heldout_gain = answer.gain;
  explanation.heldout_gain_sd = answer.gain_sd;
  const std::vector<Run> whole = whole_runs(campaign);
  explanation.train.before = free_runs(campaign, starts, {{ship, whole}}, jobs);
  std::vector<ShipOnRuns> fitted_ships = by_recording(answer.hypothesis, z.mean, campaign, whole);
  for (ShipOnRuns& one : fitted_ships) {
    one.ship.multiply(explanation.coefficient_factors);
    one.ship.residual_network = learned.network;
  }
  explanation.train.after = free_runs(campaign, starts, fitted_ships, jobs);
  const auto add_likelihood = [](Scores& scores, const FittedNull& fit, const std::vector<Run>& runs) {
    scores.log_likelihood_per_sample =
        fit.total.log_likelihood / static_cast<double>(std::max<std::size_t>(1, fit.total.measurements));
    scores.coverage = coverage(fit.smoothed, runs);
  };
  add_likelihood(explanation.train.before, all.front().fit, whole);
  add_likelihood(explanation.train.after, answer.fit, whole);
  explanation.residuals_after = residuals(campaign, answer.fit);

  explanation.heldout_is_given = !heldout.empty();
  if (explanation.heldout_is_given) {
    if (findings.corrected)
      for (Trajectory& recording : heldout)
        recording = corrected(reread(recording, findings.conventions.contradicted), findings.audit.faults);
    Campaign other = prepare(ship, heldout, {campaign.step_s, 0.0});
    const FittedNull before = follow(other, all.front().fit, {}, jobs);
    Ship stated_with = with;  // the coefficients are in theta there
    stated_with.coefficient_factors = ship.coefficient_factors;
    Campaign other_with = prepare(stated_with, heldout, {campaign.step_s, 0.0});
    const FittedNull after = follow(other_with, with_effects_in_ship(answer.fit), {}, jobs);
    const std::vector<Run> runs = whole_runs(other);
    explanation.heldout.before = free_runs(other, before.smoothed, {{ship, runs}}, jobs);
    explanation.heldout.after = free_runs(other, before.smoothed, {{with, runs}}, jobs);
    add_likelihood(explanation.heldout.before, before, runs);
    add_likelihood(explanation.heldout.after, after, runs);
    explanation.tracks_before = free_tracks(other, before.smoothed, {{ship, runs}});
    explanation.tracks_after = free_tracks(other, before.smoothed, {{with, runs}});
  } else {
    std::vector<ShipOnRuns>& after = takes_coefficients ? with_coefficients : alone;
    double likelihood_before = 0.0, likelihood_after = 0.0;
    // Innovations with what was fitted to the others.
    const Evidence of_none = comparison.blocks().total();
    std::vector<Smoothed> innovations_before = all.front().fit.smoothed, innovations_after = answer.fit.smoothed;
    const auto cover = [](const FittedNull& fit, const Eigen::VectorXd& theta, const std::vector<Run>& runs,
                          std::vector<Smoothed>& innovations) {
      for (const Run& run : runs) {
        const Smoothed there = smooth(fit.stretches[run.stretch], fit.noise, theta - fit.theta);
        std::copy(there.innovations.begin() + static_cast<std::ptrdiff_t>(run.begin),
                  there.innovations.begin() + static_cast<std::ptrdiff_t>(run.end),
                  innovations[run.stretch].innovations.begin() + static_cast<std::ptrdiff_t>(run.begin));
      }
    };
    for (std::size_t f = 0; f < comparison.folds().size(); ++f) {
      const std::vector<std::size_t>& fold = comparison.folds()[f];
      const std::vector<Run>& runs = left_out[f];
      cover(all.front().fit, refitted(all.front().fit, without(of_none, comparison.blocks(), fold)), runs,
            innovations_before);
      likelihood_before += all.front().fold_evidence[f];
      if (!learned.network) {
        cover(answer.fit, theta_of_fold[f], runs, innovations_after);
        likelihood_after += answer.fold_evidence[f];
        continue;
      }
      after[f].ship.residual_network = learned.by_fold[f];  // what differs between recordings has none
      Ship there = with;
      there.coefficient_factors = ship.coefficient_factors;
      there.residual_network = learned.by_fold[f];
      Campaign with_network = prepare(there, campaign.recordings, {campaign.step_s, 0.0});
      const FittedNull followed = follow(with_network, with_effects_in_ship(answer.fit), {}, jobs);
      cover(followed, followed.theta, runs, innovations_after);
      const Blocks of_network = blocks_of(with_network, followed, followed.noise, {0, nullptr}, jobs);
      for (const std::size_t block : fold) likelihood_after += of_network.evidence[block].log_likelihood;
    }
    explanation.heldout.before = free_runs(campaign, starts, as_stated, jobs);
    explanation.heldout.after = learned.network      ? free_runs(campaign, starts, after, jobs)
                                : takes_coefficients ? of_coefficients
                                                     : of_alone;
    explanation.heldout.before.coverage = coverage(innovations_before, whole);
    explanation.heldout.after.coverage = coverage(innovations_after, whole);
    explanation.tracks_before = free_tracks(campaign, starts, as_stated);
    explanation.tracks_after = free_tracks(campaign, starts, after);
    const auto n = static_cast<double>(std::max<std::size_t>(1, total.measurements));
    explanation.heldout.before.log_likelihood_per_sample = likelihood_before / n;
    explanation.heldout.after.log_likelihood_per_sample = likelihood_after / n;
  }
  findings.grossly_inconsistent = errs_grossly(answer.fit.report);
  explanation.notices.insert(explanation.notices.begin(), findings.notices.begin(), findings.notices.end());
  if (!unexcited.empty())
    explanation.notices.push_back(
        fmt::format("not tried, since these recordings cannot show it: {}", fmt::join(unexcited, ", ")));
  explanation.findings = std::move(findings);
  progress(1.0, "done");
  return explanation;
}

}  // namespace leeway::gap
