#include "gap/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Cholesky>

#include "core/distributions.hpp"
#include "core/errors.hpp"

namespace leeway::gap {
namespace {

constexpr double kLessPromising = 5.0;  // nats of a start behind the best: not tried
constexpr double kGainSd = 2.0;         // standard errors by which what was held out must be predicted better
constexpr double kUnexcited = 0.01;     // nats
constexpr int kRefitIterations = 20;
constexpr std::size_t kMostThatDiffer = 8;  // recordings in which an effect may differ

std::set<std::string> name_set(const Hypothesis& hypothesis) {
  const std::vector<std::string> names = hypothesis.names();
  return {names.begin(), names.end()};
}

Eigen::VectorXd pull(const FittedNull& fit) {
  return fit.prior_sd.array().square().inverse().matrix().cwiseProduct(fit.theta);
}

Eigen::MatrixXd curvature(const Eigen::MatrixXd& F, const FittedNull& fit) {
  Eigen::MatrixXd M = F;
  M.diagonal() += fit.prior_sd.array().square().inverse().matrix();
  return M;
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

// Wind, current, waves: what is another one on another day.
bool may_differ(const std::string& effect) {
  for (const EffectDescription& description : effect_catalogue())
    if (description.info.name == effect) {
      const auto& parameters = description.parameters;
      return parameters.size() == 2 && parameters[0].at_3m.kind == Prior::Kind::rayleigh;
    }
  return false;
}

}  // namespace

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

Eigen::VectorXd refitted(const FittedNull& fit, const Evidence& evidence) {
  return fit.theta + curvature(evidence.F, fit).llt().solve(evidence.b - pull(fit));
}

std::vector<EffectSpan> spans_of(const Hypothesis& hypothesis) {
  std::vector<EffectSpan> spans;
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < hypothesis.effects.size(); ++i) {
    const FreeEffect& effect = hypothesis.effects[i];
    const bool goes_on = i > 0 && effect.recording() && hypothesis.effects[i - 1].recording() &&
                         hypothesis.effects[i - 1].name() == effect.name();
    if (!goes_on) spans.push_back({i, 0, at, 0});
    ++spans.back().effects;
    spans.back().count += effect.size();
    at += effect.size();
  }
  return spans;
}

Comparison::Comparison(Campaign& campaign, const FittedNull& null, const ComparisonOptions& options)
    : campaign_(campaign), options_(options) {
  fit_options_.jobs = options.jobs;
  fit_options_.most_iterations = kRefitIterations;
  // Gone on with as the others will be, so that none gains by a few steps more.
  Fitted none;
  none.fit = fit_with(campaign, null, {}, null.theta, fit_options_);
  if (gap::log_evidence(none.fit) < gap::log_evidence(null)) none.fit = null;
  blocks_ = blocks_of(campaign, none.fit, none.fit.noise, {0, nullptr}, options.jobs);
  folds_ = folds_of(campaign, blocks_);
  none.log_evidence = gap::log_evidence(none.fit);
  none.fold_evidence = fold_evidence(none.fit, blocks_, folds_);
  all_.push_back(std::move(none));
}

std::vector<Comparison::Promise> Comparison::promises(std::size_t from, std::size_t count,
                                                      std::vector<std::string>* unexcited) {
  std::vector<Promise> result;
  const FittedNull& fit = all_[from].fit;
  const double as_it_is = marginal(fit.total, fit.theta, fit.prior_sd);
  const std::set<std::string> present = name_set(all_[from].hypothesis);
  for (const EffectDescription& description : effect_catalogue()) {
    const std::string effect(description.info.name);
    if (!EffectLibrary::holds(effect) || present.contains(effect)) continue;
    std::vector<Start> starts = starts_with(from, effect, {});
    if (starts.empty()) continue;
    if (std::abs(starts.front().log_evidence - as_it_is) < kUnexcited) {  // it changes nothing
      if (unexcited) unexcited->push_back(effect);
      continue;
    }
    result.push_back({effect, std::move(starts)});
  }
  std::stable_sort(result.begin(), result.end(), [](const Promise& a, const Promise& b) {
    return a.starts.front().log_evidence > b.starts.front().log_evidence;
  });
  if (result.size() > count) result.resize(count);
  return result;
}

std::vector<Start> Comparison::starts_with(std::size_t from, const std::string& effect,
                                           const FreeEffect::Choice& choice) {
  std::vector<Start> starts;
  const auto add = [&](const std::vector<FreeEffect::Choice>& choices) {
    for (Start& start : starts_of(effect, campaign_, all_[from].fit, options_.jobs, all_[from].hypothesis, choices))
      starts.push_back(std::move(start));
  };
  try {
    add({choice});
    std::set<std::size_t> recordings;
    for (const Stretch& stretch : campaign_.stretches) recordings.insert(stretch.recording);
    if (may_differ(effect) && !choice.recording && recordings.size() > 1 && recordings.size() <= kMostThatDiffer) {
      std::vector<FreeEffect::Choice> choices;
      for (const std::size_t recording : recordings) {
        choices.push_back(choice);
        choices.back().recording = recording;
      }
      add(choices);
    }
  } catch (const EffectNotApplicable&) {
    return {};
  }
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.log_evidence > b.log_evidence; });
  return starts;
}

std::optional<std::size_t> Comparison::add(std::size_t from, const std::vector<Start>& starts) {
  if (starts.empty()) return std::nullopt;
  const std::set<std::string> names = name_set(starts.front().hypothesis);
  for (std::size_t i = 0; i < all_.size(); ++i)
    if (name_set(all_[i].hypothesis) == names) return i;
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
  const Blocks blocks = blocks_of(campaign_, best->fit, best->fit.noise, {0, nullptr}, options_.jobs);
  best->fold_evidence = fold_evidence(best->fit, blocks, folds_);
  best->kappa = overdispersion_of(best->fit, blocks);
  std::tie(best->gain, best->gain_sd) = gain(*best, none());
  all_.push_back(std::move(*best));
  return all_.size() - 1;
}

std::pair<double, double> Comparison::gain(const Fitted& better, const Fitted& than) const {
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

double Comparison::log_odds(std::size_t i) const {
  const auto likeliest = std::max_element(
      all_.begin(), all_.end(), [](const Fitted& a, const Fitted& b) { return a.log_evidence < b.log_evidence; });
  return (all_[i].log_evidence - none().log_evidence) / likeliest->kappa +
         log_prior(all_[i].hypothesis.names().size()) - log_prior(0);
}

std::vector<double> Comparison::probabilities() const {
  std::vector<double> result;
  for (std::size_t i = 0; i < all_.size(); ++i) result.push_back(log_odds(i));
  const double largest = *std::max_element(result.begin(), result.end());
  double sum = 0.0;
  for (double& x : result) sum += x = std::exp(x - largest);
  for (double& x : result) x /= sum;
  return result;
}

bool Comparison::holds(std::size_t better, std::size_t than, double p_value) const {
  const auto [sum, sd] = gain(all_[better], all_[than]);
  const double rate = options_.false_alarm, least = p_value < rate * rate ? 1.0 : kGainSd;
  return sum > 0.0 && sum > least * sd && log_odds(better) > log_odds(than) && is_significant(all_[better]);
}

bool Comparison::is_significant(const Fitted& fitted) const {
  const Coordinates z = coordinates_of(fitted.fit);
  for (const EffectSpan& span : spans_of(fitted.hypothesis)) {
    const auto neutral = fitted.hypothesis.effects[span.effect].neutral();
    if (!neutral) continue;
    const Eigen::VectorXd away =
        z.mean.segment(span.first, span.count) - neutral->replicate(static_cast<Eigen::Index>(span.effects), 1);
    const Eigen::MatrixXd covariance = z.covariance.block(span.first, span.first, span.count, span.count);
    const double statistic = away.dot(covariance.llt().solve(away)) / fitted.kappa;
    if (chi_squared_survival(statistic, static_cast<double>(span.count)) > options_.false_alarm) return false;
  }
  return true;
}

}  // namespace leeway::gap
