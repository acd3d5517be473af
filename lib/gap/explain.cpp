#include "gap/explain.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/distributions.hpp"
#include "core/errors.hpp"
#include "gap/detect.hpp"
#include "gap/free_runs.hpp"
#include "gap/words.hpp"

namespace leeway::gap {
namespace {

constexpr double kExcited = 0.05;  // p-value of the screen above which an effect is not refitted
constexpr std::size_t kAlwaysRefitted = 3;
constexpr std::size_t kNextRefitted = 4;  // beside what was chosen
constexpr double kLessPromising = 5.0;    // nats of a start behind the best: not tried
constexpr double kGainSd = 2.0;           // standard errors by which what was held out must be predicted better
constexpr double kNotExcluded = 0.1;      // of the probability: what is not excluded against a hypothesis
constexpr double kPossible = 0.01;        // probability that is worth a word
constexpr double kUnexplained = 0.5;      // of the model error's energy that what is named must take away
constexpr double kNegligible = 0.05;      // of the evidence of what is named: what is left is not worth a word
constexpr double kUnexcited = 0.01;       // nats
constexpr int kRefitIterations = 20;

// A hypothesis with its fit.
struct Fitted {
  Hypothesis hypothesis;
  FittedNull fit;
  double log_evidence = 0.0;          // absolute
  std::vector<double> fold_evidence;  // ln p(what was left out | the rest), by fold
  double kappa = 1.0;
  double gain = 0.0, gain_sd = 0.0;  // over nothing missing

  std::set<std::string> names() const {
    std::set<std::string> result;
    for (const FreeEffect& effect : hypothesis.effects) result.insert(effect.name());
    return result;
  }
};

Eigen::VectorXd pull(const FittedNull& fit) {
  return fit.prior_sd.array().square().inverse().matrix().cwiseProduct(fit.theta);
}

Eigen::MatrixXd curvature(const Eigen::MatrixXd& F, const FittedNull& fit) {
  Eigen::MatrixXd M = F;
  M.diagonal() += fit.prior_sd.array().square().inverse().matrix();
  return M;
}

Evidence without(const Evidence& total, const Blocks& blocks, const std::vector<std::size_t>& fold) {
  Evidence others = total;
  for (const std::size_t i : fold) {
    others.b -= blocks.evidence[i].b;
    others.F -= blocks.evidence[i].F;
    others.log_likelihood -= blocks.evidence[i].log_likelihood;
    others.measurements -= blocks.evidence[i].measurements;
  }
  return others;
}

// ln p(what was left out | the rest), with the parameters integrated out.
std::vector<double> fold_evidence(const FittedNull& fit, const Blocks& blocks,
                                  const std::vector<std::vector<std::size_t>>& folds) {
  const Evidence total = blocks.total();
  const double all = marginal(total, fit.theta, fit.prior_sd);
  std::vector<double> result;
  result.reserve(folds.size());
  for (const std::vector<std::size_t>& fold : folds)
    result.push_back(all - marginal(without(total, blocks, fold), fit.theta, fit.prior_sd));
  return result;
}

// How much correlation between blocks widens what is known of the effects' strength.
double overdispersion_of(const FittedNull& fit, const Blocks& blocks) {
  const Eigen::Index effects = fit.effects, coefficients = fit.theta.size() - 1 - effects;
  if (effects == 0) return 1.0;
  const Evidence total = blocks.total();
  const Eigen::MatrixXd M = curvature(total.F, fit);
  // Beta along what was fitted, and what the coefficients make of it.
  std::vector<Eigen::Index> rest;
  for (Eigen::Index i = 0; i < fit.theta.size(); ++i)
    if (i < coefficients || i >= coefficients + effects) rest.push_back(i);
  const Eigen::VectorXd beta = fit.theta.segment(coefficients, effects);
  const Eigen::VectorXd imitated =
      M(rest, rest).llt().solve(Eigen::VectorXd(M(rest, Eigen::seqN(coefficients, effects)) * beta));
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(fit.theta.size());
  direction.segment(coefficients, effects) = beta;
  for (std::size_t i = 0; i < rest.size(); ++i) direction[rest[i]] = -imitated[static_cast<Eigen::Index>(i)];
  return overdispersion(blocks, direction, M.llt().solve(total.b - pull(fit)));
}

// ln of what is believed before: none 1/2, one effect 1/4, two 1/8, ...; all sets of a size alike.
double log_prior(std::size_t effects) {
  const std::size_t of = effect_catalogue().size();
  double result = -static_cast<double>(effects + 1) * std::log(2.0);
  for (std::size_t i = 0; i < effects; ++i)
    result -= std::log(static_cast<double>(of - i) / static_cast<double>(i + 1));
  return result;
}

// All the work on one campaign.
class Comparison {
 public:
  Comparison(Campaign& campaign, const FittedNull& null, const GapExplainOptions& options)
      : campaign_(campaign), options_(options) {
    fit_options_.jobs = options.locate.jobs;
    fit_options_.most_iterations = kRefitIterations;
    // Gone on with as the others will be, so that none gains by a few steps more.
    Fitted none;
    none.fit = fit_with(campaign, null, {}, null.theta, fit_options_);
    if (gap::log_evidence(none.fit) < gap::log_evidence(null)) none.fit = null;
    const Blocks blocks = blocks_of(campaign, none.fit, none.fit.noise, {0, nullptr}, options.locate.jobs);
    folds_ = folds_of(campaign, blocks);
    none.log_evidence = gap::log_evidence(none.fit);
    none.fold_evidence = fold_evidence(none.fit, blocks, folds_);
    all_.push_back(std::move(none));
  }

  const Fitted& none() const { return all_.front(); }
  const std::vector<Fitted>& all() const { return all_; }
  const std::vector<std::vector<std::size_t>>& folds() const { return folds_; }

  /// The effects of the catalogue that one linear step from `from` promises most of, and their starts. A screen about
  /// the fit without them would miss those that the parameters imitate, and so have left.
  struct Promise {
    std::string effect;
    std::vector<Start> starts;
  };
  std::vector<Promise> promises(std::size_t from, std::size_t count) {
    std::vector<Promise> result;
    const FittedNull& fit = all_[from].fit;
    const double as_it_is = marginal(fit.total, fit.theta, fit.prior_sd);
    for (const EffectDescription& description : effect_catalogue()) {
      const std::string effect(description.info.name);
      if (!EffectLibrary::holds(effect) || all_[from].names().contains(effect)) continue;
      std::vector<Start> starts = starts_with(from, effect, {});
      // Not excited: it changes nothing.
      if (starts.empty() || std::abs(starts.front().log_evidence - as_it_is) < kUnexcited) continue;
      result.push_back({effect, std::move(starts)});
    }
    std::stable_sort(result.begin(), result.end(), [](const Promise& a, const Promise& b) {
      return a.starts.front().log_evidence > b.starts.front().log_evidence;
    });
    if (result.size() > count) result.resize(count);
    return result;
  }
  std::vector<Start> starts_with(std::size_t from, const std::string& effect, const FreeEffect::Choice& choice) {
    try {
      return starts_of(effect, campaign_, all_[from].fit, options_.locate.jobs, all_[from].hypothesis, choice);
    } catch (const EffectNotApplicable&) {
      return {};
    }
  }

  /// Fits `from` with one effect more, and keeps the result; its place, or nothing where it cannot be fitted.
  std::optional<std::size_t> add(std::size_t from, const std::vector<Start>& starts) {
    if (starts.empty()) return std::nullopt;
    std::set<std::string> names;
    for (const FreeEffect& effect : starts.front().hypothesis.effects) names.insert(effect.name());
    for (std::size_t i = 0; i < all_.size(); ++i)
      if (all_[i].names() == names) return i;
    std::optional<Fitted> best;
    for (std::size_t i = 0; i < std::min<std::size_t>(2, starts.size()); ++i) {
      if (starts[i].log_evidence < starts.front().log_evidence - kLessPromising) break;
      try {
        Fitted fitted;
        fitted.hypothesis = starts[i].hypothesis;
        fitted.fit = fit_with(campaign_, all_[from].fit, fitted.hypothesis, starts[i].theta, fit_options_);
        fitted.log_evidence = gap::log_evidence(fitted.fit);
        if (!best || fitted.log_evidence > best->log_evidence) best = std::move(fitted);
      } catch (const NumericalError&) {  // with this effect the simulator runs away: it is no explanation
      }
    }
    if (!best) return std::nullopt;
    const Blocks blocks = blocks_of(campaign_, best->fit, best->fit.noise, {0, nullptr}, options_.locate.jobs);
    best->fold_evidence = fold_evidence(best->fit, blocks, folds_);
    best->kappa = overdispersion_of(best->fit, blocks);
    std::tie(best->gain, best->gain_sd) = gain(*best, none());
    all_.push_back(std::move(*best));
    return all_.size() - 1;
  }

  /// Sum over the folds of what `better` predicts better, and its standard error.
  std::pair<double, double> gain(const Fitted& better, const Fitted& than) const {
    const auto n = static_cast<double>(folds_.size());
    double sum = 0.0, square = 0.0;
    for (std::size_t f = 0; f < folds_.size(); ++f) {
      const double g = (better.fold_evidence[f] - than.fold_evidence[f]) / better.kappa;
      sum += g;
      square += g * g;
    }
    const double variance = n > 1.0 ? std::max(0.0, (square - sum * sum / n) / (n - 1.0)) : 0.0;
    return {sum, std::sqrt(variance * n)};
  }

  /// ln of the posterior odds against nothing missing. Correlation between blocks takes from all evidence what it takes
  /// from that of the likeliest.
  double log_odds(std::size_t i) const {
    const auto likeliest = std::max_element(
        all_.begin(), all_.end(), [](const Fitted& a, const Fitted& b) { return a.log_evidence < b.log_evidence; });
    return (all_[i].log_evidence - none().log_evidence) / likeliest->kappa +
           log_prior(all_[i].hypothesis.effects.size()) - log_prior(0);
  }
  std::vector<double> probabilities() const {
    std::vector<double> result;
    for (std::size_t i = 0; i < all_.size(); ++i) result.push_back(log_odds(i));
    const double largest = *std::max_element(result.begin(), result.end());
    double sum = 0.0;
    for (double& x : result) sum += x = std::exp(x - largest);
    for (double& x : result) x /= sum;
    return result;
  }

  /// Whether `better` is likelier than `than`, predicts what was left out better beyond chance, and each of its effects
  /// is more than nothing.
  ///   p_value  of something being left beside `than`: where it is tiny, one standard error is enough
  bool holds(std::size_t better, std::size_t than, double p_value) const {
    const auto [sum, sd] = gain(all_[better], all_[than]);
    const double rate = options_.locate.false_alarm, least = p_value < rate * rate ? 1.0 : kGainSd;
    return sum > 0.0 && sum > least * sd && log_odds(better) > log_odds(than) && is_significant(all_[better]);
  }

 private:
  bool is_significant(const Fitted& fitted) const {
    const Coordinates z = coordinates_of(fitted.fit);
    Eigen::Index at = 0;
    for (const FreeEffect& effect : fitted.hypothesis.effects) {
      const Eigen::Index n = effect.size();
      if (const auto neutral = effect.neutral()) {
        const Eigen::VectorXd away = z.mean.segment(at, n) - *neutral;
        const double statistic = away.dot(z.covariance.block(at, at, n, n).llt().solve(away)) / fitted.kappa;
        if (chi_squared_survival(statistic, static_cast<double>(n)) > options_.locate.false_alarm) return false;
      }
      at += n;
    }
    return true;
  }

  Campaign& campaign_;
  const GapExplainOptions& options_;
  FitOptions fit_options_;
  std::vector<Fitted> all_;
  std::vector<std::vector<std::size_t>> folds_;
};

// What is left beside a hypothesis: the screen around its fit.
Detection left_beside(const Campaign& campaign, const Fitted& fitted, const GapExplainOptions& options) {
  const Coordinates z = coordinates_of(fitted.fit);
  Campaign with = campaign;
  with.ship = fitted.hypothesis.applied_to(campaign.ship, z.mean);
  const double delay_s = Effects<double>(with.ship).rudder_delay_s();
  FittedNull fit = fitted.fit;
  for (std::size_t s = 0; s < with.stretches.size(); ++s) {
    if (delay_s != Effects<double>(campaign.ship).rudder_delay_s())
      set_inputs(with.stretches[s], with.recorded_inputs[with.stretches[s].recording], with.ship, delay_s);
    fit.stretches[s].data = &with.stretches[s];
  }
  const EffectLibrary library(with, fit);
  DetectOptions detect_options;
  detect_options.false_alarm = options.locate.false_alarm;
  detect_options.jobs = options.locate.jobs;
  detect_options.seed = options.locate.seed;
  detect_options.refitted = 3;
  return detect(with, fit, library, detect_options);
}

const EffectInfo& info_of(const std::string& effect) {
  for (const EffectDescription& description : effect_catalogue())
    if (description.info.name == effect) return description.info;
  throw UsageError(fmt::format("no effect '{}' in the catalogue", effect));
}

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
  Eigen::Index at = 0;
  const Coordinates z = coordinates_of(fitted.fit);
  for (const FreeEffect& effect : fitted.hypothesis.effects) {
    result.effects.push_back(effect.name());
    sentences.emplace_back(info_of(effect.name()).sentence);
    maneuvers.emplace_back(info_of(effect.name()).separating_maneuver);
    const Eigen::Index n = effect.size();
    for (const FreeEffect::Parameter& p :
         effect.parameters(z.mean.segment(at, n), fitted.kappa * z.covariance.block(at, at, n, n))) {
      ExplainedParameter one{effect.name(), p.name, p.estimate, p.sd, p.low, p.high};
      if (one.name == "delay_s") {
        const double sd = std::hypot(p.sd, timing_sd_s(campaign)), wider = sd / std::max(p.sd, 1e-12);
        one = {one.effect,
               one.name,
               p.estimate,
               sd,
               std::max(0.0, p.estimate - wider * (p.estimate - p.low)),
               p.estimate + wider * (p.high - p.estimate)};
      }
      result.parameters.push_back(one);
    }
    at += n;
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
FreeEffect::Choice tug_in(const Interval& interval) {
  return {0.0, {{"t_start_s", interval.t_start_s}, {"t_end_s", interval.t_end_s}}, {"x_m"}};
}

Explained told(const Fault& fault) {
  Explained result;
  result.name = fault.name;
  result.effects = {fault.name};
  result.sentence = fault.sentence;
  result.heldout_gain = fault.heldout_gain;
  result.heldout_gain_sd = fault.heldout_gain_sd;
  result.log_evidence = fault.heldout_gain;
  result.probability = 1.0 - std::clamp(fault.p_value, 0.0, 1.0);
  result.converged = true;
  for (const Estimate& e : fault.parameters)
    result.parameters.push_back({fault.name, e.name, e.value, e.sd, e.value - 1.96 * e.sd, e.value + 1.96 * e.sd});
  return result;
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
  Comparison comparison(campaign, investigation.null, options);
  const bool is_searched = findings.verdict != Verdict::no_mismatch;
  std::size_t best = 0;
  const auto better = [&](std::optional<std::size_t> i) {
    if (i && comparison.log_odds(*i) > comparison.log_odds(best)) best = *i;
  };
  const auto first = comparison.promises(0, is_searched ? options.refitted : kAlwaysRefitted);
  for (std::size_t i = 0; i < first.size(); ++i) {
    progress(0.45 + 0.3 * static_cast<double>(i) / static_cast<double>(first.size()), "fit with " + first[i].effect);
    better(comparison.add(0, first[i].starts));
  }
  if (is_searched && !findings.located.intervals.empty() &&
      findings.located.intervals.front().p_value < options.locate.false_alarm && recordings.size() == 1)
    better(comparison.add(0, comparison.starts_with(0, "tug", tug_in(findings.located.intervals.front()))));
  // Not the best, but what predicts better what was left out.
  std::size_t chosen = is_searched && comparison.holds(best, 0, findings.detection.p_value) ? best : 0;
  double left_p = chosen == 0 ? findings.detection.p_value : 1.0;
  bool is_negligible = false;  // what is left
  while (chosen != 0) {
    const std::size_t size = comparison.all()[chosen].hypothesis.effects.size();
    progress(0.75 + 0.04 * static_cast<double>(size),
             "what is left beside " + comparison.all()[chosen].hypothesis.name());
    const Detection left = left_beside(campaign, comparison.all()[chosen], options);
    left_p = left.p_value;
    if (left.p_value >= options.locate.false_alarm || size >= options.most_effects) break;
    std::optional<std::size_t> next;
    for (const auto& promise : comparison.promises(chosen, kNextRefitted))
      if (const auto added = comparison.add(chosen, promise.starts))
        if (!next || comparison.all()[*added].log_evidence > comparison.all()[*next].log_evidence) next = added;
    const auto evidence = [&](std::size_t i) { return comparison.all()[i].log_evidence; };
    is_negligible = next && evidence(*next) - evidence(chosen) < kNegligible * (evidence(chosen) - evidence(0));
    if (!next || !comparison.holds(*next, chosen, left_p)) break;
    chosen = *next;
  }
  // One that was taken first may have stood in for two others.
  for (bool is_shorter = chosen != 0; is_shorter;) {
    is_shorter = false;
    const std::vector<FreeEffect> effects = comparison.all()[chosen].hypothesis.effects;
    if (effects.size() < 2) break;
    for (std::size_t out = 0; out < effects.size() && !is_shorter; ++out) {
      std::optional<std::size_t> reduced = std::size_t{0};
      for (std::size_t i = 0; i < effects.size() && reduced; ++i)
        if (i != out) reduced = comparison.add(*reduced, comparison.starts_with(*reduced, effects[i].name(), {}));
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
  for (Explained& hypothesis : explanation.hypotheses)
    for (const Explained& other : explanation.hypotheses)
      if (&other != &hypothesis && other.probability > std::max(kNotExcluded * hypothesis.probability, kPossible))
        hypothesis.confusable_with.push_back(other.name);

  const Fitted& answer = all[chosen];
  explanation.left_p_value = left_p;
  const bool is_something = chosen != 0 || findings.detection.p_value < options.locate.false_alarm;
  if (chosen != 0) explanation.verdict = Verdict::mismatch;
  if (explanation.verdict == Verdict::mismatch && is_something) {
    const double L = ship.particulars.L_pp;
    const double taken = 1.0 - energy(answer.fit.noise.sigma_w, L) / energy(findings.fit.sigma_w, L);
    explanation.is_complete = chosen != 0 && (left_p >= options.locate.false_alarm || is_negligible);
    if (chosen != 0 && (explanation.is_complete || taken > kUnexplained))
      for (const std::string& name : answer.names()) explanation.chosen.push_back(name);
    if (!explanation.is_complete) explanation.chosen.push_back("unknown");
  }
  if (!findings.conventions.contradicted.empty()) {
    explanation.chosen.insert(explanation.chosen.begin(), "convention");
    explanation.verdict = Verdict::mismatch;
  }
  for (const Fault& fault : findings.audit.faults) {
    explanation.chosen.insert(explanation.chosen.begin(), fault.name);
    explanation.hypotheses.push_back(told(fault));
    explanation.verdict = Verdict::mismatch;
  }
  std::stable_sort(explanation.hypotheses.begin(), explanation.hypotheses.end(),
                   [](const Explained& a, const Explained& b) { return a.probability > b.probability; });

  progress(0.9, "free runs before and after");
  const Coordinates z = coordinates_of(answer.fit);
  const Ship with = answer.hypothesis.applied_to(campaign.ship, z.mean);
  explanation.effects.assign(with.effects.begin() + static_cast<std::ptrdiff_t>(campaign.ship.effects.size()),
                             with.effects.end());
  explanation.heldout_gain = answer.gain;
  explanation.heldout_gain_sd = answer.gain_sd;
  const std::size_t jobs = options.locate.jobs;
  const std::vector<Run> whole = whole_runs(campaign);
  explanation.train.before = free_runs(campaign, investigation.null.smoothed, {{ship, whole}}, jobs);
  explanation.train.after = free_runs(campaign, investigation.null.smoothed, {{with, whole}}, jobs);
  const auto add_likelihood = [](Scores& scores, const FittedNull& fit) {
    scores.log_likelihood_per_sample =
        fit.total.log_likelihood / static_cast<double>(std::max<std::size_t>(1, fit.total.measurements));
    scores.coverage_95 = coverage(fit.smoothed);
  };
  add_likelihood(explanation.train.before, all.front().fit);
  add_likelihood(explanation.train.after, answer.fit);

  explanation.heldout_is_given = !heldout.empty();
  if (explanation.heldout_is_given) {
    if (findings.corrected)
      for (Trajectory& recording : heldout)
        recording = corrected(reread(recording, findings.conventions.contradicted), findings.audit.faults);
    Campaign other = prepare(ship, heldout, {campaign.step_s, 0.0});
    const FittedNull before = follow(other, all.front().fit, {}, jobs);
    const FittedNull after = follow(other, answer.fit, answer.hypothesis, jobs);
    const std::vector<Run> runs = whole_runs(other);
    explanation.heldout.before = free_runs(other, before.smoothed, {{ship, runs}}, jobs);
    explanation.heldout.after = free_runs(other, before.smoothed, {{with, runs}}, jobs);
    add_likelihood(explanation.heldout.before, before);
    add_likelihood(explanation.heldout.after, after);
  } else {
    const Blocks blocks = blocks_of(campaign, answer.fit, answer.fit.noise, {0, nullptr}, jobs);
    const Evidence total = blocks.total();
    std::vector<ShipOnRuns> before, after;
    double likelihood_before = 0.0, likelihood_after = 0.0;
    for (std::size_t f = 0; f < comparison.folds().size(); ++f) {
      const std::vector<std::size_t>& fold = comparison.folds()[f];
      const std::vector<Run> runs = runs_of(campaign, blocks, fold);
      const Evidence others = without(total, blocks, fold);
      const Eigen::VectorXd theta =
          answer.fit.theta + curvature(others.F, answer.fit).llt().solve(others.b - pull(answer.fit));
      const Eigen::Index effects = answer.fit.effects;
      before.push_back({ship, runs});
      after.push_back(
          {answer.hypothesis.applied_to(campaign.ship, theta.segment(theta.size() - 1 - effects, effects)), runs});
      likelihood_before += all.front().fold_evidence[f];
      likelihood_after += answer.fold_evidence[f];
    }
    explanation.heldout.before = free_runs(campaign, investigation.null.smoothed, before, jobs);
    explanation.heldout.after = free_runs(campaign, investigation.null.smoothed, after, jobs);
    const auto n = static_cast<double>(std::max<std::size_t>(1, total.measurements));
    explanation.heldout.before.log_likelihood_per_sample = likelihood_before / n;
    explanation.heldout.after.log_likelihood_per_sample = likelihood_after / n;
  }
  findings.grossly_inconsistent = errs_grossly(answer.fit.report);
  explanation.notices = findings.notices;
  explanation.findings = std::move(findings);
  progress(1.0, "done");
  return explanation;
}

}  // namespace leeway::gap
