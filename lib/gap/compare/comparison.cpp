#include "gap/compare/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "core/distributions.hpp"
#include "core/linear_algebra.hpp"
#include "core/units.hpp"
#include "gap/compare/candidates.hpp"
#include "gap/compare/places.hpp"
#include "gap/compare/terms.hpp"
#include "gap/decide/decide.hpp"
#include "gap/detect/effect_library.hpp"
#include "gap/detect/gains_of_nothing.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

void sort(std::vector<Comparison::ExpectedGain>& expected_gains) {
  std::stable_sort(expected_gains.begin(), expected_gains.end(),
                   [](const Comparison::ExpectedGain& a, const Comparison::ExpectedGain& b) {
                     return a.starts.front().log_evidence > b.starts.front().log_evidence;
                   });
}

}  // namespace

Comparison::Comparison(const Campaign& campaign, const FittedNull& null, const ComparisonOptions& options)
    : campaign_(campaign), options_(options), search_(campaign, {.jobs = options.jobs}) {
  // Gone on with as the others will be, so that none gains by a few steps more.
  Fitted none;
  none.fit = null;
  if (options.none_is_possible) search_.continue_fit(none);
  search_.choose_scale(none);
  if (options.none_is_possible) search_.fit_as_stated(none);
  blocks_ = blocks_of(campaign, none.fit, none.fit.noise, {0, nullptr}, options.jobs);
  folds_ = folds_of(campaign, blocks_);
  none.fold_evidence = fold_evidence(blocks_, folds_, none.fit.theta, none.fit.prior);
  all_.push_back(std::move(none));
}

std::vector<Comparison::ExpectedGain> Comparison::expected_gains(std::size_t from, std::vector<std::string>* unexcited,
                                                                 std::vector<ExpectedGain>* pairs) {
  if (const auto known = expected_.find(from); known != expected_.end() && !unexcited && !pairs) return known->second;
  const FittedNull& fit = all_[from].fit;
  const std::set<std::string> present = name_set(all_[from].hypothesis);
  std::vector<Candidate> candidates;
  const Identifiable is_identifiable(campaign_, all_.front().fit);
  for (const EffectDescription& description : effect_catalogue()) {
    const std::string effect(description.info.name);
    if (!is_screened(description.info.search) && description.info.search != SearchStart::course) continue;
    if (present.contains(effect)) continue;
    if (!is_identifiable(effect)) {
      if (unexcited) unexcited->push_back(effect);
      continue;
    }
    for (Candidate& candidate : candidates_with(campaign_, effect, {})) candidates.push_back(std::move(candidate));
  }
  std::vector<EffectScreen> screens;
  for (const double share : {1.0, 0.0})
    if (share == 1.0 || is_shifted(fit))
      screens.emplace_back(campaign_, fit, all_[from].hypothesis, candidates, share,
                           widths_by_scale(fit.stated, fit.parameters, fit.effects), ScreenOptions{options_.jobs});
  gains_of_nothing_[from] = screens.front().gains_of_nothing(kPolicy.compare.draws_of_nothing, options_.seed);

  std::vector<double> nothing_more;
  nothing_more.reserve(screens.size());
  for (const EffectScreen& screen : screens) nothing_more.push_back(screen.log_evidence({}));
  std::vector<ExpectedGain> result;
  std::map<std::string, std::vector<std::size_t>> best_of;  // by effect: its candidates
  for (std::size_t c = 0; c < candidates.size();) {
    const std::string& effect = candidates[c].effects.front().name();
    ExpectedGain expected{effect, {}, 0.0};
    double most = -std::numeric_limits<double>::infinity();
    bool is_excited = false;
    const std::size_t begin = c;
    while (c < candidates.size() && candidates[c].effects.front().name() == effect) ++c;
    for (std::size_t s = 0; s < screens.size(); ++s)
      for (const std::vector<std::size_t>& set : sets_of(screens[s], begin, c, false)) {
        expected.starts.push_back(screens[s].start(set));
        const double evidence = expected.starts.back().log_evidence;
        is_excited |= std::abs(evidence - nothing_more[s]) > kPolicy.compare.unexcited;
        if (evidence > most) most = evidence, best_of[effect] = set;
      }
    if (!is_excited) {
      if (unexcited) unexcited->push_back(effect);
      best_of.erase(effect);
      continue;
    }
    sort(expected.starts);
    expected.gain = most - nothing_more.front();
    screened_[from][effect] = expected.gain;
    result.push_back(std::move(expected));
  }
  if (pairs) {  // both from the same coefficients
    for (auto a = best_of.begin(); a != best_of.end(); ++a)
      for (auto b = std::next(a); b != best_of.end(); ++b) {
        std::vector<std::size_t> both = a->second;
        both.insert(both.end(), b->second.begin(), b->second.end());
        Start best = screens.front().start(both);
        for (std::size_t s = 1; s < screens.size(); ++s)
          if (Start start = screens[s].start(both); start.log_evidence > best.log_evidence) best = std::move(start);
        pairs->push_back({best.hypothesis.name(), {best}, best.log_evidence - nothing_more.front()});
      }
    sort(*pairs);
  }
  sort(result);
  expected_[from] = result;
  return result;
}

std::vector<Comparison::ExpectedGain> Comparison::expected_gains_of_places(std::size_t from,
                                                                           const std::vector<Interval>& events) {
  const bool acts_at_times = !events.empty();
  const std::set<std::string> present = name_set(all_[from].hypothesis);
  std::vector<ExpectedGain> result;
  for (const EffectDescription& description : effect_catalogue()) {
    const auto& [info, parameters] = description;
    const std::string effect(info.name);
    if (info.bound_to != BoundTo::place || present.contains(effect)) continue;
    if (info.search == SearchStart::contact && !acts_at_times) continue;
    std::vector<Candidate> candidates;
    for (const FreeEffect::Choice& choice : places_of(effect, campaign_, events))
      for (Candidate& candidate : candidates_of(effect, campaign_.ship, {choice}))
        candidates.push_back(std::move(candidate));
    if (candidates.empty()) continue;
    ScreenOptions screen_options{options_.jobs};
    // What fenders and lines that go taut do are events.
    screen_options.knows_events = info.search == SearchStart::wall || !acts_at_times;
    ExpectedGain expected{effect, {}, 0.0};
    double nothing = 0.0;
    const std::size_t at_a_time = kPolicy.compare.places_at_a_time;
    for (std::size_t first = 0; first < candidates.size(); first += at_a_time) {
      const auto begin = candidates.begin() + static_cast<std::ptrdiff_t>(first);
      const std::size_t count = std::min(at_a_time, candidates.size() - first);
      const EffectScreen screen =
          screen_of(campaign_, all_[from], {begin, begin + static_cast<std::ptrdiff_t>(count)}, screen_options);
      nothing = screen.log_evidence({});
      for (std::size_t c = 0; c < count; ++c)  // but those that the ship does not reach
        if (Start start = screen.start({c}); std::abs(start.log_evidence - nothing) > kPolicy.compare.unexcited)
          expected.starts.push_back(std::move(start));
    }
    if (expected.starts.empty()) continue;
    sort(expected.starts);
    if (info.search == SearchStart::anchor)
      take_turns(expected.starts);
    else
      keep_apart(expected.starts);
    expected.gain = expected.starts.front().log_evidence - nothing;
    result.push_back(std::move(expected));
  }
  sort(result);
  return result;
}

std::vector<Start> Comparison::starts_with(std::size_t from, const std::string& effect,
                                           const FreeEffect::Choice& choice) {
  const FittedNull& fit = all_[from].fit;
  const std::vector<Candidate> candidates = candidates_with(campaign_, effect, choice);
  std::vector<Start> starts;
  for (const double share : {1.0, 0.0}) {
    if (candidates.empty() || (share == 0.0 && !is_shifted(fit))) break;
    const EffectScreen screen(campaign_, fit, all_[from].hypothesis, candidates, share,
                              widths_by_scale(fit.stated, fit.parameters, fit.effects), {options_.jobs});
    for (const auto& set : sets_of(screen, 0, candidates.size(), choice.recording.has_value()))
      starts.push_back(screen.start(set));
  }
  sort(starts);
  return starts;
}

std::optional<std::size_t> Comparison::add(std::size_t from, const std::vector<Start>& starts,
                                           std::size_t most_starts) {
  if (starts.empty()) return std::nullopt;
  const std::set<std::string> names = name_set(starts.front().hypothesis);
  for (std::size_t i = 0; i < all_.size(); ++i)
    if (name_set(all_[i].hypothesis) == names) return i;
  std::optional<Fitted> best = search_.fit(all_[from], starts, most_starts);
  if (!best) return std::nullopt;
  if (is_below_known_angles(*best) || is_another_effect(*best)) return std::nullopt;
  if (from != 0 && none().fit.report.is_noise_free && !is_worth_a_name(*best, all_[from])) return std::nullopt;
  judge(*best);
  all_.push_back(std::move(*best));
  return all_.size() - 1;
}

std::optional<std::size_t> Comparison::add_as_stated(std::size_t from, const std::vector<Start>& starts) {
  return !starts.empty() && may_begin_as_stated(all_[from], starts.front()) ? add(from, starts, 0) : std::nullopt;
}

double Comparison::cost_of_shifts(std::size_t from) const {
  const FittedNull& fit = all_[from].fit;
  Eigen::VectorXd as_stated = fit.theta;
  as_stated.head(as_stated.size() - 1 - fit.effects).setZero();
  return fit.stated.log_density(as_stated) - fit.stated.log_density(fit.theta);
}

void Comparison::judge(Fitted& fitted) const {
  const Blocks blocks = blocks_of(campaign_, fitted.fit, fitted.fit.noise, {0, nullptr}, options_.jobs);
  fitted.fold_evidence = fold_evidence(blocks, folds_, fitted.fit.theta, fitted.fit.prior);
  fitted.kappa = overdispersion_of(fitted.fit, blocks);
  std::tie(fitted.gain, fitted.gain_sd) = gain(fitted, none());
}

bool Comparison::refit_none(std::size_t from) {
  std::optional<Fitted> none = search_.better_none(all_.front(), all_[from]);
  if (!none) return false;
  all_.clear();
  screened_.clear();
  gains_of_nothing_.clear();
  expected_.clear();
  all_.push_back(std::move(*none));
  blocks_ = blocks_of(campaign_, all_.front().fit, all_.front().fit.noise, {0, nullptr}, options_.jobs);
  all_.front().fold_evidence = fold_evidence(blocks_, folds_, all_.front().fit.theta, all_.front().fit.prior);
  return true;
}

void Comparison::refine(std::size_t i) {
  if (search_.continue_fit(all_[i])) {
    judge(all_[i]);
    expected_.erase(i);
  }
  refine_scale(i);
}

void Comparison::refine_scale(std::size_t i) {
  if (!search_.fit_as_stated(all_[i])) return;
  judge(all_[i]);
  expected_.erase(i);
}

// Noise levels may converge to a better place than with the effect that it then is: evidence alone does not decide.
bool Comparison::is_another_effect(const Fitted& fitted) const {
  const Coordinates z = coordinates_of(fitted.fit);
  for (const EffectSpan& span : spans_of(fitted.hypothesis)) {
    std::vector<Eigen::Index> places = fitted.hypothesis.effects[span.effect].beside_vector();
    if (places.empty()) continue;
    for (Eigen::Index& place : places) place += span.first;
    const Eigen::VectorXd own = z.mean(places);
    const Eigen::MatrixXd covariance = z.covariance(places, places);
    const double statistic = own.dot(covariance.llt().solve(own)) / fitted.kappa;
    if (chi_squared_survival(statistic, static_cast<double>(places.size())) > options_.false_alarm) return true;
  }
  return false;
}

bool Comparison::is_worth_a_name(const Fitted& with, const Fitted& without) const {
  const Vec3<double>& typical = none().fit.report.typical;
  const Vec3<double> after = with.fit.noise.sigma_w.cwiseQuotient(typical),
                     before = without.fit.noise.sigma_w.cwiseQuotient(typical);
  const double taken = std::sqrt(std::max(0.0, (before.cwiseAbs2() - after.cwiseAbs2()).maxCoeff()));
  return before.maxCoeff() > kPolicy.decide.error_of_inputs || taken > kPolicy.compare.worth_a_name ||
         with.fit.log_prior_of_events > without.fit.log_prior_of_events;
}

bool Comparison::is_below_known_angles(const Fitted& fitted) const {
  const RudderResponse own = rudder_response_of(campaign_.ship);
  const Coordinates z = coordinates_of(fitted.fit);
  double moved = 0.0, points = 0.0;
  for (const Stretch& stretch : campaign_.stretches) {
    const RudderResponse response =
        rudder_response_of(fitted.hypothesis.applied_to(campaign_.ship, z.mean, stretch.recording));
    if (response == own) return false;
    const RecordedInputs& recorded = campaign_.recorded_inputs[stretch.recording];
    const auto here = static_cast<double>(stretch.size());
    moved += here * angle_change(stretch, recorded.through(own), recorded.through(response));
    points += here;
  }
  // Without noise everything shows, also what rudders really do between two samples.
  const bool is_of_inputs = none().fit.report.is_noise_free && !is_worth_a_name(fitted, none());
  return is_of_inputs || moved < points * kKnownAngle * kKnownAngle;
}

double Comparison::chance_of(std::size_t i, std::size_t than) const {
  const auto drawn = gains_of_nothing_.find(than);
  if (drawn == gains_of_nothing_.end() || i == than) return 1.0;
  const double odds = log_odds(i) - log_odds(than);
  // The drawn campaigns know the noise levels, which so few measurements do not tell.
  if (drawn->second.empty() || none().fit.report.samples < kPolicy.decide.fewest_samples)
    return std::min(1.0, std::exp(-odds));
  return chance_of_gain(drawn->second, odds - log_prior_odds_of_one(all_[than].hypothesis.names().size()));
}

bool Comparison::holds(std::size_t better, std::size_t than, bool is_surely_left) const {
  const auto [sum, sd] = gain(all_[better], all_[than]);
  const Fitted& one = all_[better];
  return gap::holds({.log_odds = log_odds(better) - log_odds(than),
                     .is_significant = is_significant(one),
                     .has_terms = has_terms(one.hypothesis.names()),
                     .is_rare = is_rare(better, than),
                     .gain = sum,
                     .gain_sd = sd,
                     .is_surely_left = is_surely_left,
                     .is_likelier_than_not = than != 0 && is_likelier_than_not(better)});
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
