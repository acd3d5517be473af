#include "gap/comparison.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <Eigen/Cholesky>

#include "core/distributions.hpp"
#include "core/errors.hpp"
#include "core/units.hpp"
#include "gap/current_course.hpp"
#include "gap/effect_library.hpp"

namespace leeway::gap {
namespace {

constexpr double kLessPromising = 5.0;  // nats of a start behind the best: not tried
constexpr double kLess = 2.0;           // nats below the fit without an effect: it rests in a worse place
constexpr double kGainSd = 2.0;         // standard errors by which what was held out must be predicted better
constexpr double kStrongOdds = 5.0;     // nats
// Of the typical acceleration: what must be taken away where no more is left than inputs between the samples make.
constexpr double kWorthAName = 0.02;
constexpr double kSettled = 0.5;    // nats by which a fit may still gain
constexpr double kElsewhere = 2.0;  // nats by which the fit of nothing missing rests in a better place
constexpr double kTemper = 3.0;     // of stated probabilities: docs/gap-explain.md
constexpr std::array kTolerances{0.0, 0.5, 1.0};
constexpr int kMostTolerances = 2;   // that a fit moves to
constexpr double kUnexcited = 0.01;  // nats
constexpr int kRefitIterations = 20;
constexpr double kFarBelow = 0.2;          // of the model error
constexpr std::size_t kFewPoints = 10000;  // of a campaign, that allow every fit that does not rest to begin anew
constexpr int kMostTimes = 5;              // that a fit is gone on with
// Of the sampling time: rudders that are later by less are not told from what they do between two samples.
constexpr double kTellableShare = 0.5;
constexpr std::size_t kMostThatDiffer = 8;  // recordings in which an effect may differ
constexpr int kMostShifts = 20;
constexpr double kFirstShift_s = 8.0, kLastShift_s = 1.0;  // of a tug's begin and end, at 3 m
constexpr std::size_t kTellingTerms = 12;                  // of the effect unknown, of which sets are formed
constexpr int kBanks = 8, kFenders = 24;                   // directions
constexpr int kFineDirections = 120;
constexpr double kApart_deg = 15.0;
constexpr std::array kDepths{0.01, 0.03, 0.1};  // of a hull in a fender, by its length
constexpr std::array kSlacks{0.4, 0.8, 0.95};   // of a line, by its greatest length
constexpr int kAnchors = 3;                     // to each side of the middle

std::set<std::string> name_set(const Hypothesis& hypothesis) {
  const std::vector<std::string> names = hypothesis.names();
  return {names.begin(), names.end()};
}

Prior about(double median, double sd, double low = -std::numeric_limits<double>::infinity()) {
  return normal(median, sd, std::max(low, median - 8.0 * sd), median + 8.0 * sd);
}

// How far the hull, a box, reaches in a direction.
double reach_of(const Vec6& measured, const Vec2<double>& towards, const Particulars& ship) {
  const double along = towards(0) * std::cos(measured(2)) + towards(1) * std::sin(measured(2)),
               across = towards(1) * std::cos(measured(2)) - towards(0) * std::sin(measured(2)),
               half = 0.5 * ship.L_pp * std::abs(along) + 0.5 * ship.B * std::abs(across);
  return measured.head<2>().dot(towards) + (std::isnan(half) ? 0.5 * ship.B : half);
}

// Where a bank, a fender or a mooring line may be, about the tracks.
//   events  when something acts: there the directions of walls are tried more finely
std::vector<FreeEffect::Choice> places_of(const std::string& effect, const Campaign& campaign,
                                          const std::vector<Interval>& events) {
  std::vector<Vec6> visited;
  std::vector<bool> in_event;
  for (const Stretch& stretch : campaign.stretches)
    for (std::size_t k = 0; k < stretch.size(); ++k) {
      if (!stretch.measured[k].head<2>().allFinite()) continue;
      visited.push_back(stretch.measured[k]);
      in_event.push_back(std::any_of(events.begin(), events.end(), [&](const Interval& event) {
        const double around_s = event.t_end_s - event.t_start_s;
        return event.file == campaign.recordings[stretch.recording].file &&
               event.t_start_s - around_s <= stretch.t_s[k] && stretch.t_s[k] <= event.t_end_s + around_s;
      }));
    }
  if (visited.empty()) return {};
  const double L = campaign.ship.particulars.L_pp, B = campaign.ship.particulars.B;
  std::vector<FreeEffect::Choice> result;
  const auto add = [&](double towards_deg, std::map<std::string, Prior> priors) {
    FreeEffect::Choice choice;
    choice.towards_deg = towards_deg;
    if (priors.contains("slack_length_m")) choice.freed = {"slack_length_m"};
    choice.priors = std::move(priors);
    result.push_back(std::move(choice));
  };
  if (effect == "mooring") {
    Vec2<double> low = visited.front().head<2>(), high = low;
    for (const Vec6& place : visited) low = low.cwiseMin(place.head<2>()), high = high.cwiseMax(place.head<2>());
    const Vec2<double> middle = 0.5 * (low + high), half = 0.5 * (high - low) + Vec2<double>(2.0 * L, 2.0 * L);
    for (int i = -kAnchors; i <= kAnchors; ++i)
      for (int j = -kAnchors; j <= kAnchors; ++j) {
        const Vec2<double> anchor = middle + Vec2<double>(i, j).cwiseProduct(half) / kAnchors;
        double farthest = 0.0;
        for (const Vec6& place : visited) farthest = std::max(farthest, (place.head<2>() - anchor).norm());
        const std::map<std::string, Prior> place{{"anchor_x_m", about(anchor(0), half(0))},
                                                 {"anchor_y_m", about(anchor(1), half(1))}};
        add(0.0, place);
        for (const double slack : kSlacks) {
          std::map<std::string, Prior> with_slack = place;
          with_slack["slack_length_m"] = about(slack * farthest, 0.5 * farthest, 0.0);
          add(0.0, std::move(with_slack));
        }
      }
    return result;
  }
  const int every = kFineDirections / (effect == "bank" ? kBanks : kFenders);
  for (int k = 0; k < kFineDirections; ++k) {
    const double angle = 2.0 * kPi * k / kFineDirections;
    const Vec2<double> towards{std::cos(angle), std::sin(angle)};
    double midship = -std::numeric_limits<double>::infinity(), hull = midship;
    bool acts_there = false;  // where the hull reaches farthest
    for (std::size_t i = 0; i < visited.size(); ++i) {
      midship = std::max(midship, visited[i].head<2>().dot(towards));
      if (const double reach = reach_of(visited[i], towards, campaign.ship.particulars); reach > hull)
        hull = reach, acts_there = in_event[i];
    }
    if (k % every != 0 && !acts_there) continue;
    if (effect == "bank")  // that the tracks do not touch
      add(angle / kDegree, {{"wall_distance_m", about(midship + 1.5 * B, 1.5 * B)}});
    else  // that the hull touches somewhere
      for (const double depth : kDepths) add(angle / kDegree, {{"wall_distance_m", about(hull - depth * L, 1.5 * B)}});
  }
  return result;
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

// Prior widths with the coefficients' as wide as a tolerance says.
Eigen::VectorXd widths(const FittedNull& fit, double tolerance) {
  Eigen::VectorXd result = fit.prior_sd;
  const Eigen::Index coefficients = fit.theta.size() - 1 - fit.effects;
  for (Eigen::Index i = 0; i < coefficients; ++i) {
    const UncertainParameter& p = fit.parameters[static_cast<std::size_t>(i)];
    result[i] = std::exp((1.0 - tolerance) * std::log(p.log_sd) + tolerance * std::log(p.tolerated_sd));
  }
  return result;
}

std::vector<Eigen::VectorXd> tolerances(const FittedNull& fit) {
  std::vector<Eigen::VectorXd> result;
  result.reserve(kTolerances.size());
  for (const double tolerance : kTolerances) result.push_back(widths(fit, tolerance));
  return result;
}

// The start of what was added to a fit from where it is nothing; none where that is infinitely far.
std::optional<Start> at_neutral(const Fitted& from, const Start& added) {
  Start start{added.hypothesis, added.theta, from.log_evidence};
  const Eigen::Index known = from.fit.theta.size() - 1;
  start.theta.head(known) = from.fit.theta.head(known);
  start.theta[start.theta.size() - 1] = from.fit.theta[known];
  Eigen::Index at = known;
  for (std::size_t i = from.hypothesis.effects.size(); i < added.hypothesis.effects.size(); ++i) {
    const std::optional<Eigen::VectorXd> neutral = added.hypothesis.effects[i].neutral();
    if (!neutral) return std::nullopt;
    start.theta.segment(at, neutral->size()) = *neutral;
    at += neutral->size();
  }
  return start;
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

// ln of the number of sets of `count` things out of `of`.
double log_ways(std::size_t of, std::size_t count) {
  double result = 0.0;
  for (std::size_t i = 0; i < count; ++i) result += std::log(static_cast<double>(of - i) / static_cast<double>(i + 1));
  return result;
}

// ln of what is believed before: none 1/5, one effect 2/5, two 1/5, three 1/10, ...; all sets of a size alike, and all
// sets of terms, all intervals.
//   with_ways  false: without what the choice among intervals and terms costs
double log_prior(const Hypothesis& hypothesis, bool with_ways = true) {
  const std::size_t effects = hypothesis.names().size();
  double result = -std::log(5.0) - log_ways(effect_catalogue().size(), effects);
  if (effects > 0) result -= (static_cast<double>(effects) - 2.0) * std::log(2.0);
  for (const FreeEffect& effect : hypothesis.effects) {
    if (!with_ways) break;
    result -= effect.log_ways();
    if (effect.name() == "unknown")
      result -= log_ways(effect_named("unknown").parameters.size(), static_cast<std::size_t>(effect.size()));
  }
  return result;
}

// A vector and nothing else (current, wind, a pull): another one on another day. So is the course of a current.
bool may_differ(const std::string& effect) {
  if (effect == kVaryingCurrent) return true;
  const auto& parameters = effect_named(effect).parameters;
  return parameters.size() == 2 && parameters[0].at_3m.kind == Prior::Kind::rayleigh;
}

// What is tried of the candidates [begin, end), which belong to one effect: each that acts everywhere, and of those
// that act in one recording alone the best of each, together.
std::vector<std::vector<std::size_t>> sets_of(const EffectScreen& screen, std::size_t begin, std::size_t end,
                                              bool is_of_one_recording) {
  std::vector<std::vector<std::size_t>> sets;
  std::map<std::size_t, std::pair<double, std::size_t>> best_in;
  for (std::size_t c = begin; c < end; ++c) {
    const auto& recording = screen.candidates()[c].effects.front().recording();
    if (!recording || is_of_one_recording) {
      sets.push_back({c});
      continue;
    }
    const double evidence = screen.log_evidence({c});
    const auto [place, is_new] = best_in.try_emplace(*recording, evidence, c);
    if (!is_new && evidence > place->second.first) place->second = {evidence, c};
  }
  if (best_in.empty()) return sets;
  sets.emplace_back();
  for (const auto& [recording, best] : best_in) sets.back().push_back(best.second);
  return sets;
}

void sort(std::vector<Start>& starts) {
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.log_evidence > b.log_evidence; });
}

// Of walls in nearly the same direction the most promising one.
void keep_apart(std::vector<Start>& starts) {
  std::vector<Start> kept;
  for (Start& start : starts) {
    const double towards_deg = start.hypothesis.effects.back().towards_deg();
    if (std::none_of(kept.begin(), kept.end(), [&](const Start& other) {
          const double apart_deg = towards_deg - other.hypothesis.effects.back().towards_deg();
          return std::abs(wrap_angle(apart_deg * kDegree)) < kApart_deg * kDegree;
        }))
      kept.push_back(std::move(start));
  }
  starts = std::move(kept);
}

void sort(std::vector<Comparison::Promise>& promises) {
  std::stable_sort(promises.begin(), promises.end(), [](const Comparison::Promise& a, const Comparison::Promise& b) {
    return a.starts.front().log_evidence > b.starts.front().log_evidence;
  });
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
  none.fit = null;
  if (options.none_is_possible) go_on(none, campaign.points() <= kFewPoints);
  settle_tolerance(none);
  blocks_ = blocks_of(campaign, none.fit, none.fit.noise, {0, nullptr}, options.jobs);
  folds_ = folds_of(campaign, blocks_);
  none.fold_evidence = fold_evidence(none.fit, blocks_, folds_);
  all_.push_back(std::move(none));
}

std::vector<Comparison::Promise> Comparison::promises(std::size_t from, std::vector<std::string>* unexcited,
                                                      std::vector<Start>* pair) {
  const FittedNull& fit = all_[from].fit;
  const std::set<std::string> present = name_set(all_[from].hypothesis);
  std::vector<Candidate> candidates;
  const Tellable is_tellable(campaign_);
  for (const EffectDescription& description : effect_catalogue()) {
    const std::string effect(description.info.name);
    if (!EffectLibrary::holds(effect) || present.contains(effect)) continue;
    if (!is_tellable(effect)) {
      if (unexcited) unexcited->push_back(effect);
      continue;
    }
    for (Candidate& candidate : candidates_with(effect, {})) candidates.push_back(std::move(candidate));
  }
  std::vector<EffectScreen> screens;
  for (const double share : {1.0, 0.0})
    if (share == 1.0 || is_bent(fit))
      screens.emplace_back(campaign_, fit, all_[from].hypothesis, candidates, share, tolerances(fit),
                           ScreenOptions{options_.jobs});

  std::vector<Promise> result;
  std::map<std::string, std::vector<std::size_t>> best_of;  // by effect: its candidates
  for (std::size_t c = 0; c < candidates.size();) {
    const std::string& effect = candidates[c].effects.front().name();
    Promise promise{effect, {}, 0.0};
    double most = -std::numeric_limits<double>::infinity();
    bool is_excited = false;
    const std::size_t begin = c;
    while (c < candidates.size() && candidates[c].effects.front().name() == effect) ++c;
    for (const EffectScreen& screen : screens)
      for (const std::vector<std::size_t>& set : sets_of(screen, begin, c, false)) {
        promise.starts.push_back(screen.start(set));
        const double evidence = promise.starts.back().log_evidence;
        is_excited |= std::abs(evidence - screen.log_evidence({})) > kUnexcited;
        if (evidence > most) most = evidence, best_of[effect] = set;
      }
    if (!is_excited) {
      if (unexcited) unexcited->push_back(effect);
      best_of.erase(effect);
      continue;
    }
    sort(promise.starts);
    promise.gain = most - screens.front().log_evidence({});
    screened_[from][effect] = promise.gain;
    result.push_back(std::move(promise));
  }
  if (pair) {  // both from the same coefficients
    for (const auto& [a, of_a] : best_of)
      for (const auto& [b, of_b] : best_of) {
        if (!(a < b)) continue;
        std::vector<std::size_t> both = of_a;
        both.insert(both.end(), of_b.begin(), of_b.end());
        for (const EffectScreen& screen : screens)
          if (const double evidence = screen.log_evidence(both); pair->empty() || evidence > pair->front().log_evidence)
            pair->assign({screen.start(both)});
      }
  }
  sort(result);
  return result;
}

std::vector<Comparison::Promise> Comparison::promises_of_places(std::size_t from, const std::vector<Interval>& events) {
  const bool acts_at_times = !events.empty();
  const std::set<std::string> present = name_set(all_[from].hypothesis);
  std::vector<Promise> result;
  for (const std::string effect : {"bank", "mooring", "fender"}) {
    if (present.contains(effect) || (effect == "fender" && !acts_at_times)) continue;
    std::vector<Candidate> candidates;
    for (const FreeEffect::Choice& choice : places_of(effect, campaign_, events))
      for (Candidate& candidate : candidates_of(effect, campaign_.ship, {choice}))
        candidates.push_back(std::move(candidate));
    if (candidates.empty()) continue;
    // What fenders and lines that go taut do are events. There are many places of what acts always.
    ScreenOptions screen_options{options_.jobs};
    screen_options.knows_events = effect == "bank" || !acts_at_times;
    if (effect != "fender") screen_options.most_points = kFewPoints;
    const EffectScreen screen = screen_of(from, candidates, screen_options);
    result.push_back({effect, {}, 0.0});
    Promise& promise = result.back();
    for (std::size_t c = 0; c < candidates.size(); ++c)  // but those that the ship does not reach
      if (std::abs(screen.log_evidence({c}) - screen.log_evidence({})) > kUnexcited)
        promise.starts.push_back(screen.start({c}));
    if (promise.starts.empty()) {
      result.pop_back();
      continue;
    }
    sort(promise.starts);
    if (effect != "mooring") keep_apart(promise.starts);
    promise.gain = promise.starts.front().log_evidence - screen.log_evidence({});
  }
  sort(result);
  return result;
}

std::vector<Start> Comparison::terms_beside(std::size_t from) {
  const std::span<const EffectParameter> all_terms = effect_named("unknown").parameters;
  const auto only = [&](const std::vector<std::size_t>& terms) {
    FreeEffect::Choice choice;
    for (std::size_t i = 0; i < all_terms.size(); ++i)
      if (std::find(terms.begin(), terms.end(), i) == terms.end()) choice.fixed[std::string(all_terms[i].name)] = 0.0;
    return FreeEffect("unknown", campaign_.ship, choice);
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < all_terms.size(); ++i) candidates.push_back({{only({i})}, Eigen::VectorXd::Zero(1)});
  const EffectScreen screen = screen_of(from, std::move(candidates), {options_.jobs});

  // With what the choice among all sets of a size costs.
  const auto worth = [&](const std::vector<std::size_t>& terms) {
    return screen.log_evidence(terms) - log_ways(all_terms.size(), terms.size());
  };
  std::vector<std::pair<double, std::size_t>> singles;
  for (std::size_t i = 0; i < all_terms.size(); ++i) singles.emplace_back(-worth({i}), i);
  std::sort(singles.begin(), singles.end());
  const std::size_t n = std::min(kTellingTerms, singles.size());
  std::vector<std::size_t> best;
  double most = worth({});
  const auto consider = [&](std::vector<std::size_t> terms) {
    std::sort(terms.begin(), terms.end());
    if (const double w = worth(terms); w > most) most = w, best = std::move(terms);
  };
  for (std::size_t i = 0; i < n; ++i) {
    consider({singles[i].second});
    for (std::size_t j = 0; j < i; ++j) {
      consider({singles[i].second, singles[j].second});
      for (std::size_t k = 0; k < j; ++k) consider({singles[i].second, singles[j].second, singles[k].second});
    }
  }
  if (best.empty()) return {};
  Start start = screen.start(best);
  start.hypothesis = all_[from].hypothesis;
  start.hypothesis.effects.push_back(only(best));
  return {start};
}

std::vector<Candidate> Comparison::candidates_with(const std::string& effect, const FreeEffect::Choice& choice) const {
  std::set<std::size_t> recordings;
  for (const Stretch& stretch : campaign_.stretches) recordings.insert(stretch.recording);
  try {
    std::vector<Candidate> result = candidates_of(effect, campaign_.ship, {choice});
    if (may_differ(effect) && !choice.recording && recordings.size() > 1 && recordings.size() <= kMostThatDiffer)
      for (const std::size_t recording : recordings) {
        FreeEffect::Choice there = choice;
        there.recording = recording;
        for (Candidate& candidate : candidates_of(effect, campaign_.ship, {there}))
          result.push_back(std::move(candidate));
      }
    return result;
  } catch (const EffectNotApplicable&) {
    return {};
  }
}

std::vector<Start> Comparison::starts_with(std::size_t from, const std::string& effect,
                                           const FreeEffect::Choice& choice) {
  const FittedNull& fit = all_[from].fit;
  const std::vector<Candidate> candidates = candidates_with(effect, choice);
  std::vector<Start> starts;
  for (const double share : {1.0, 0.0}) {
    if (candidates.empty() || (share == 0.0 && !is_bent(fit))) break;
    const EffectScreen screen(campaign_, fit, all_[from].hypothesis, candidates, share, tolerances(fit),
                              {options_.jobs});
    for (const auto& set : sets_of(screen, 0, candidates.size(), choice.recording.has_value()))
      starts.push_back(screen.start(set));
  }
  sort(starts);
  return starts;
}

Candidate Comparison::tug_in(std::size_t from, const Interval& interval) const {
  FreeEffect::Choice choice;
  choice.freed = {"x_m"};
  choice.log_ways = std::log(static_cast<double>(interval.searched)) + 2.0 * std::log(kFirstShift_s / kLastShift_s);
  double from_s = interval.t_start_s, until_s = interval.t_end_s;  // of the stretch
  for (const Stretch& stretch : campaign_.stretches)
    if (campaign_.recordings[stretch.recording].file == interval.file && stretch.t_s.front() <= interval.t_start_s &&
        interval.t_start_s <= stretch.t_s.back()) {
      from_s = stretch.t_s.front(), until_s = stretch.t_s.back();
      if (campaign_.recordings.size() > 1) choice.recording = stretch.recording;
    }
  const auto best_of = [&](const std::vector<Candidate>& candidates) {
    const EffectScreen screen = screen_of(from, candidates, {options_.jobs, false});
    std::vector<Start> starts;
    for (std::size_t c = 0; c < candidates.size(); ++c) starts.push_back(screen.start({c}));
    sort(starts);
    return starts.front();
  };
  const auto z_of = [](const Start& start) -> Eigen::VectorXd {
    const Eigen::Index size = start.hypothesis.effects.back().size();
    return start.theta.segment(start.theta.size() - 1 - size, size);
  };
  double begin_s = interval.t_start_s, end_s = interval.t_end_s;
  choice.fixed = {{"t_start_s", begin_s}, {"t_end_s", end_s}};
  Start best = best_of(candidates_of("tug", campaign_.ship, {choice}));
  const double scale = campaign_.time_scale();
  double shift_s = kFirstShift_s * scale;
  for (int i = 0; i < kMostShifts && shift_s >= kLastShift_s * scale; ++i) {
    FreeEffect tug = best.hypothesis.effects.back();
    const Eigen::VectorXd z = z_of(best);
    std::vector<Candidate> candidates;
    for (const double a : {0.0, -1.0, 1.0})
      for (const double b : {0.0, -1.0, 1.0}) {
        const double begin = std::max(from_s, begin_s + a * shift_s), end = std::min(until_s, end_s + b * shift_s);
        if (end - begin < shift_s) continue;
        tug.fix("t_start_s", begin);
        tug.fix("t_end_s", end);
        candidates.push_back({{tug}, z});
      }
    if (candidates.empty()) break;
    best = best_of(candidates);
    const std::vector<double> now = best.hypothesis.effects.back().values(z);
    const std::size_t n = now.size();  // begin and end stand last
    const bool rests = std::abs(now[n - 2] - begin_s) < 1e-9 && std::abs(now[n - 1] - end_s) < 1e-9;
    begin_s = now[n - 2], end_s = now[n - 1];
    if (rests) shift_s *= 0.5;
  }
  return {{best.hypothesis.effects.back()}, z_of(best)};
}

EffectScreen Comparison::screen_of(std::size_t from, std::vector<Candidate> candidates,
                                   const ScreenOptions& options) const {
  const Fitted& fitted = all_[from];
  return {campaign_, fitted.fit, fitted.hypothesis, std::move(candidates), 1.0, tolerances(fitted.fit), options};
}

std::vector<Start> Comparison::starts_with_tugs(std::size_t from, const std::vector<Interval>& intervals) const {
  std::vector<Candidate> tugs;
  std::vector<std::size_t> all;
  for (const Interval& interval : intervals) {
    all.push_back(tugs.size());
    tugs.push_back(tug_in(from, interval));
    tugs.back().effects.front().count_from(tugs.front().effects.front().towards_deg(), tugs.back().z);
  }
  return {screen_of(from, std::move(tugs), {options_.jobs, false}).start(all)};
}

// With what a tug is known by now, its begin and end are known better than they were sought: pieces with its force, or
// against it, are tried at both ends, all in one pass, until none gains.
void Comparison::mend_tugs(Fitted& fitted) {
  struct Piece {
    std::size_t tug;
    std::string end;
    double time_s;
  };
  const std::span<const EffectParameter> parameters = effect_named("tug").parameters;
  for (int round = 0; round < kMostShifts; ++round) {
    std::vector<Candidate> candidates;
    std::vector<Piece> pieces;
    const Coordinates z = coordinates_of(fitted.fit);
    Eigen::Index at = 0;
    for (std::size_t i = 0; i < fitted.hypothesis.effects.size(); ++i) {
      const FreeEffect& tug = fitted.hypothesis.effects[i];
      const std::vector<double> now = tug.values(z.mean.segment(at, tug.size()));
      at += tug.size();
      if (tug.name() != "tug") continue;
      FreeEffect::Choice choice;
      choice.recording = tug.recording();
      for (std::size_t p = 0; p < parameters.size(); ++p) choice.fixed[std::string(parameters[p].name)] = now[p];
      const double force = now.front(), begin = choice.fixed["t_start_s"], end = choice.fixed["t_end_s"];
      for (const double shift : {-4.0, -2.0, -1.0, 1.0, 2.0, 4.0})
        for (const bool at_end : {false, true}) {
          const double before = at_end ? end : begin, after = before + shift * kLastShift_s * campaign_.time_scale();
          if (!(at_end ? begin < after : after < end)) continue;
          choice.fixed["t_start_s"] = std::min(before, after);
          choice.fixed["t_end_s"] = std::max(before, after);
          choice.fixed["force_N"] = (after > before) == at_end ? force : -force;
          candidates.push_back({{FreeEffect("tug", campaign_.ship, choice)}, Eigen::VectorXd()});
          pieces.push_back({i, at_end ? "t_end_s" : "t_start_s", after});
        }
    }
    if (candidates.empty()) return;
    const EffectScreen screen(campaign_, fitted.fit, fitted.hypothesis, candidates, 1.0, {fitted.fit.prior_sd},
                              {options_.jobs});
    std::map<std::pair<std::size_t, std::string>, std::pair<double, double>> best;  // gain and time
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      auto& [gain, time_s] = best[{pieces[c].tug, pieces[c].end}];
      const double gains = screen.log_evidence({c}) - screen.log_evidence({});
      if (gains > std::max(gain, kSettled)) gain = gains, time_s = pieces[c].time_s;
    }
    Fitted next = fitted;
    bool moves = false;
    for (const auto& [end, found] : best) {
      if (!(found.first > 0.0)) continue;
      next.hypothesis.effects[end.first].fix(end.second, found.second);
      moves = true;
    }
    if (!moves) return;
    try {
      next.fit = fit_with(campaign_, fitted.fit, next.hypothesis, fitted.fit.theta, fit_options_);
    } catch (const NumericalError&) {
      return;
    }
    next.log_evidence = gap::log_evidence(next.fit);
    if (next.log_evidence < fitted.log_evidence + kSettled) return;
    fitted = std::move(next);
  }
}

std::optional<std::size_t> Comparison::add(std::size_t from, const std::vector<Start>& starts,
                                           std::size_t most_starts) {
  if (starts.empty()) return std::nullopt;
  const std::set<std::string> names = name_set(starts.front().hypothesis);
  for (std::size_t i = 0; i < all_.size(); ++i)
    if (name_set(all_[i].hypothesis) == names) return i;
  const auto fitted_from = [&](const Start& start) -> std::optional<Fitted> {
    try {
      Fitted fitted;
      fitted.hypothesis = start.hypothesis;
      fitted.fit = fit_with(campaign_, all_[from].fit, fitted.hypothesis, start.theta, fit_options_);
      fitted.log_evidence = gap::log_evidence(fitted.fit);
      if (!std::isfinite(fitted.log_evidence)) return std::nullopt;
      return fitted;
    } catch (const NumericalError&) {  // with this effect the simulator runs away: it is no explanation
      return std::nullopt;
    }
  };
  std::optional<Fitted> best;
  for (std::size_t i = 0; i < std::min(most_starts, starts.size()); ++i) {
    if (starts[i].log_evidence < starts.front().log_evidence - kLessPromising) break;
    if (auto fitted = fitted_from(starts[i]); fitted && (!best || fitted->log_evidence > best->log_evidence))
      best = std::move(fitted);
  }
  if (best) settle_tolerance(*best);
  if (best && names.contains("tug") && !name_set(all_[from].hypothesis).contains("tug")) mend_tugs(*best);
  // Where the effect is nothing it is as likely as without it.
  if (!best || best->log_evidence < all_[from].log_evidence - kLess)
    if (const std::optional<Start> nothing = at_neutral(all_[from], starts.front()))
      if (auto fitted = fitted_from(*nothing)) {
        settle_tolerance(*fitted);
        if (!best || fitted->log_evidence > best->log_evidence) best = std::move(fitted);
      }
  if (!best) return std::nullopt;
  if (!best->fit.report.converged) go_on(*best, campaign_.points() <= kFewPoints);
  if (is_between_samples(*best) || is_another_effect(*best)) return std::nullopt;
  if (from != 0 && !is_worth_a_name(*best, all_[from])) return std::nullopt;
  judge(*best);
  all_.push_back(std::move(*best));
  return all_.size() - 1;
}

void Comparison::judge(Fitted& fitted) const {
  const Blocks blocks = blocks_of(campaign_, fitted.fit, fitted.fit.noise, {0, nullptr}, options_.jobs);
  fitted.fold_evidence = fold_evidence(fitted.fit, blocks, folds_);
  fitted.kappa = overdispersion_of(fitted.fit, blocks);
  std::tie(fitted.gain, fitted.gain_sd) = gain(fitted, none());
}

bool Comparison::go_on(Fitted& fitted, bool anew) {
  const double before = gap::log_evidence(fitted.fit);
  fitted.log_evidence = before;
  // Also from far below: where an effect has taken most of the model error away, its levels may rest halfway; and the
  // coefficients far from what is stated, if they stood in for it.
  for (const auto& [share, as_stated] : {std::pair{1.0, false}, {kFarBelow, false}, {kFarBelow, true}})
    for (int i = 0; i < kMostTimes && (anew || share == 1.0); ++i) {
      FittedNull next = fitted.fit;
      if (i == 0) next.noise.sigma_w *= share;
      if (i == 0 && as_stated) next.theta.head(next.theta.size() - 1 - next.effects).setZero();
      try {
        next = fit_with(campaign_, next, fitted.hypothesis, next.theta, fit_options_);
      } catch (const NumericalError&) {
        break;
      }
      const double gained = gap::log_evidence(next) - fitted.log_evidence;
      if (gained > 0.0) {
        fitted.fit = std::move(next);
        fitted.log_evidence += gained;
      }
      if (gained < kSettled) break;
    }
  return fitted.log_evidence > before + kSettled;
}

bool Comparison::settle_none(std::size_t from) {
  if (campaign_.points() > kFewPoints) return false;
  const Fitted& other = all_[from];
  Fitted none = all_.front();
  none.fit.noise = other.fit.noise;
  none.fit.event_scale = other.fit.event_scale;
  const Eigen::Index coefficients = none.fit.theta.size() - 1;
  Eigen::VectorXd theta = none.fit.theta;
  theta.head(coefficients) = other.fit.theta.head(coefficients);
  theta[coefficients] = other.fit.theta[other.fit.theta.size() - 1];
  try {
    none.fit = fit_with(campaign_, none.fit, none.hypothesis, theta, fit_options_);
  } catch (const NumericalError&) {
    return false;
  }
  settle_tolerance(none);
  if (none.log_evidence < all_.front().log_evidence + kElsewhere) return false;
  all_.clear();
  screened_.clear();
  all_.push_back(std::move(none));
  blocks_ = blocks_of(campaign_, all_.front().fit, all_.front().fit.noise, {0, nullptr}, options_.jobs);
  all_.front().fold_evidence = fold_evidence(all_.front().fit, blocks_, folds_);
  return true;
}

void Comparison::settle(std::size_t i) {
  if (go_on(all_[i])) judge(all_[i]);
}

// Noise levels may rest in a better place than with the effect that it then is, so that evidence alone does not tell.
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
  const Vec3<double> typical = none().fit.report.typical.cwiseMax(1e-12);
  const Vec3<double> after = with.fit.noise.sigma_w.cwiseQuotient(typical),
                     before = without.fit.noise.sigma_w.cwiseQuotient(typical);
  const double taken = std::sqrt(std::max(0.0, (before.cwiseAbs2() - after.cwiseAbs2()).maxCoeff()));
  return before.maxCoeff() > kErrorOfInputs || taken > kWorthAName ||
         with.fit.log_prior_of_events > without.fit.log_prior_of_events;
}

bool Comparison::is_between_samples(const Fitted& fitted) const {
  const RudderResponse own = Effects<double>(campaign_.ship).rudder_response();
  const Coordinates z = coordinates_of(fitted.fit);
  const double timing = fitted.fit.theta[fitted.fit.theta.size() - 1];
  double moved = 0.0, not_known = 0.0;  // sums of squares
  for (const Stretch& stretch : campaign_.stretches) {
    RudderResponse response =
        Effects<double>(fitted.hypothesis.applied_to(campaign_.ship, z.mean, stretch.recording)).rudder_response();
    if (response == own) return false;
    response.delay_s += kTimingShare * stretch.sample_s * timing;
    RudderResponse late = own;
    late.delay_s += kTellableShare * stretch.sample_s;
    const RecordedInputs& recorded = campaign_.recorded_inputs[stretch.recording];
    const RecordedInputs as_is = recorded.through(own), with = recorded.through(response),
                         later = recorded.through(late);
    const auto points = static_cast<double>(stretch.size());
    moved += points * angle_change(stretch, as_is, with);
    not_known += points * std::max(angle_change(stretch, as_is, later), kKnownAngle * kKnownAngle);
  }
  return moved < not_known;
}

void Comparison::settle_tolerance(Fitted& fitted) {
  FittedNull& fit = fitted.fit;
  for (int i = 0; i < kMostTolerances; ++i) {
    Eigen::VectorXd best = fit.prior_sd;
    double most = -std::numeric_limits<double>::infinity();
    for (const Eigen::VectorXd& sd : tolerances(fit))
      if (const double evidence = marginal(fit.total, fit.theta, sd); evidence > most) most = evidence, best = sd;
    if (best.isApprox(fit.prior_sd)) break;
    FittedNull other = fit;
    other.prior_sd = best;
    try {
      other = fit_with(campaign_, other, fitted.hypothesis, other.theta, fit_options_);
    } catch (const NumericalError&) {
      break;
    }
    // The levels of the noise move with it, and may come to rest in a worse place.
    if ((!other.report.converged && fit.report.converged) || gap::log_evidence(other) < gap::log_evidence(fit)) break;
    fit = std::move(other);
  }
  for (const double tolerance : kTolerances)
    if (widths(fit, tolerance).isApprox(fit.prior_sd)) fitted.tolerance = tolerance;
  fitted.log_evidence = gap::log_evidence(fit);
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
  return (all_[i].log_evidence - none().log_evidence) / likeliest->kappa + log_prior(all_[i].hypothesis) -
         log_prior({});
}

std::vector<double> Comparison::probabilities() const {
  // Effects that promised too little to be fitted beside a hypothesis share in it as well; likelier hypotheses than
  // were screened are as likely to lack another effect that does not show.
  const auto unseen_beside = [&](std::size_t from, double temper) {
    double share = 0.0;
    const auto screened = screened_.find(from);
    if (screened == screened_.end()) return share;
    for (const auto& [effect, gain] : screened->second) {
      Hypothesis more = all_[from].hypothesis;
      more.effects.emplace_back(effect, campaign_.ship);
      if (std::any_of(all_.begin(), all_.end(),
                      [&](const Fitted& fitted) { return name_set(fitted.hypothesis) == name_set(more); }))
        continue;
      // One linear step exaggerates: a promise alone makes nothing likelier than without it.
      share += std::exp(std::min(gain, 0.0) / temper + log_prior(more) - log_prior(all_[from].hypothesis));
    }
    return share;
  };
  // Whether something is missing: the evidence counts whole.
  std::vector<double> whole(all_.size());
  for (std::size_t i = 1; i < all_.size(); ++i) whole[i] = log_odds(i);
  const double most = *std::max_element(whole.begin(), whole.end());
  double something = 0.0;
  for (std::size_t i = 1; i < all_.size(); ++i) something += std::exp(whole[i] - most);
  const double nothing = std::exp(-most), all = nothing * (1.0 + unseen_beside(0, 1.0)) + something;
  // What it is: the evidence is tempered, and with it what the choice of the place where it is largest costs; what was
  // believed before counts whole.
  std::vector<double> tempered(all_.size(), -std::numeric_limits<double>::infinity());
  for (std::size_t i = 1; i < all_.size(); ++i) {
    const double prior = log_prior(all_[i].hypothesis, false) - log_prior({});
    tempered[i] = (whole[i] - prior) / kTemper + prior;
  }
  const double largest = *std::max_element(tempered.begin(), tempered.end());
  double sum = 0.0;
  for (std::size_t i = 1; i < all_.size(); ++i) sum += tempered[i] = std::exp(tempered[i] - largest);
  if (screened_.size() > 1) sum *= 1.0 + unseen_beside(screened_.rbegin()->first, kTemper);
  std::vector<double> result{nothing / all};
  for (std::size_t i = 1; i < all_.size(); ++i) result.push_back(something / all * tempered[i] / sum);
  return result;
}

bool Comparison::holds(std::size_t better, std::size_t than, double p_value) const {
  const auto [sum, sd] = gain(all_[better], all_[than]);
  const double rate = options_.false_alarm, odds = log_odds(better) - log_odds(than);
  if (!(odds > 0.0) || !is_significant(all_[better])) return false;
  // What a coefficient could do as well, if it were far off what is stated, predicts no better: it is likelier alone.
  // Terms are likelier wherever forms of forces differ.
  const bool has_strong_names = odds > kStrongOdds && !name_set(all_[better].hypothesis).contains("unknown");
  if (than == 0 && odds > kStrong && has_strong_names) return sum > -kGainSd * sd;
  const double least = has_strong_names ? 0.0 : p_value < rate * rate || odds > kStrongOdds ? 1.0 : kGainSd;
  return sum > 0.0 && sum > least * sd;
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
