#include "gap/compare/selection.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "gap/compare/latent_forces.hpp"
#include "gap/compare/terms.hpp"
#include "gap/decide/found.hpp"
#include "gap/detect/detect.hpp"
#include "gap/locate/locate.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// What is left beside a hypothesis: effects of the catalogue around its fit, and intervals.
struct Left {
  double p_value;  // of both
  Strongest interval;
};

Left left_beside(const Campaign& campaign, const Fitted& fitted, const GapExplainOptions& options) {
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
    const RudderResponse response = rudder_response_of(with.ship_in(r));
    if (response != rudder_response_of(campaign.ship))
      set_inputs(with.stretches[s], with.recorded_inputs[r].through(response), with.ship);
    fit.stretches[s].data = std::make_shared<const Stretch>(with.stretches[s]);
  }
  const EffectLibrary library(with, fit);
  DetectOptions detect_options;
  detect_options.false_alarm = options.locate.false_alarm;
  detect_options.jobs = options.locate.jobs;
  detect_options.seed = options.locate.seed;
  detect_options.refitted = kPolicy.compare.refitted_beside;
  LocateOptions locate_options;
  locate_options.false_alarm = options.locate.false_alarm;
  locate_options.jobs = options.locate.jobs;
  locate_options.seed = options.locate.seed;
  Left left{detect(with, fit, library, detect_options).p_value, strongest_interval(with, fit, locate_options)};
  left.p_value = std::min(1.0, kPolicy.compare.families_beside * std::min(left.p_value, left.interval.p_value));
  return left;
}

class Selector {
 public:
  Selector(const Campaign& campaign, const Findings& findings, Comparison& comparison, const GapExplainOptions& options)
      : campaign_(campaign),
        findings_(findings),
        comparison_(comparison),
        options_(options),
        is_searched_(findings.verdict != Verdict::no_mismatch) {
    selection_.error = error_of(findings.fit.sigma_w, findings.located.intervals);
  }

  Selection run() {
    fit_all();
    if (likeliest_ != 0 && evidence(likeliest_) - evidence(0) < kPolicy.compare.beyond_doubt &&
        comparison_.refit_none(likeliest_))
      fit_all();
    find_latent();
    take_likeliest();
    take_more();
    take_terms();
    drop_needless();
    take_latent();
    describe_unknown();
    return std::move(selection_);
  }

 private:
  void fit_all() {
    likeliest_ = 0;
    fit_names();
    fit_terms();
    if (!is_searched_ && comparison_.log_odds(likeliest_) > kPolicy.compare.strong_terms) search();
  }
  /// Also where the tests see nothing.
  void search() {
    is_searched_ = true;
    fit_names();
  }
  void fit_names() {
    fit_singles();
    fit_others();
    if (is_searched_) fit_pairs();
  }
  void progress(double done, const std::string& note) const {
    if (options_.locate.progress) options_.locate.progress(done, note);
  }
  double error_of(const Vec3<double>& sigma_w, const std::vector<Interval>& intervals) const {
    const Vec3<double>& typical = findings_.fit.typical;
    double error = sigma_w.cwiseQuotient(typical).maxCoeff();
    // Events are no part of sigma_w.
    for (const Interval& interval : intervals)
      if (!interval.is_small && interval.p_value < options_.locate.false_alarm)
        error = std::max(error, std::abs(interval.acceleration[interval.axis]) / typical[interval.axis]);
    return error;
  }
  const Hypothesis& hypothesis(std::size_t i) const { return comparison_.all()[i].hypothesis; }
  double evidence(std::size_t i) const { return comparison_.all()[i].log_evidence; }

  /// Takes note of a fit.
  void better(std::optional<std::size_t> i) {
    if (i && comparison_.log_odds(*i) > comparison_.log_odds(likeliest_)) likeliest_ = *i;
  }

  /// Fitted is one by one, until what comes next expected_gains far less than what was found.
  bool is_hopeless(double expected, std::optional<std::size_t> found, std::size_t beside,
                   double share = kPolicy.compare.hopeless_share,
                   double far_behind = kPolicy.compare.far_behind) const {
    if (!found) return false;
    const double gained = evidence(*found) - evidence(beside);
    return expected < share * gained && expected < gained - far_behind;
  }

  /// What one linear step expects to gain beside a fit [nats].
  double expected_of(const std::vector<Start>& starts, std::size_t beside) const {
    return starts.empty() ? 0.0 : starts.front().log_evidence - evidence(beside);
  }

  /// What begins and ends is sought in the intervals where it was.
  std::vector<Start> starts_with(std::size_t from, const std::string& effect) const {
    if (search_start(effect) == SearchStart::interval)
      return starts_in_intervals(campaign_, comparison_.all()[from], effect, intervals_, options_.locate.jobs);
    return comparison_.starts_with(from, effect, {});
  }
  /// The likeliest of the effects that begin and end, but those that expect far less than `found`.
  std::optional<std::size_t> add_in_intervals(std::size_t from, std::vector<Interval> intervals,
                                              std::optional<std::size_t> found = std::nullopt) {
    std::optional<std::size_t> best;
    for (const std::string& effect : effects_searched_from(SearchStart::interval)) {
      const std::vector<Start> starts =
          starts_in_intervals(campaign_, comparison_.all()[from], effect, intervals, options_.locate.jobs);
      if (is_hopeless(expected_of(starts, from), found, from)) continue;
      if (const auto added = comparison_.add(from, starts))
        if (!best || evidence(*added) > evidence(*best)) best = added;
    }
    if (best) intervals_ = std::move(intervals);
    return best;
  }
  /// The same in the interval in which something likeliest acts.
  std::optional<std::size_t> add_in_the_likeliest(std::size_t from, std::optional<std::size_t> found = std::nullopt) {
    const auto interval = likeliest_interval(campaign_, comparison_.all()[from].fit, options_.locate.jobs);
    return interval ? add_in_intervals(from, {*interval}, found) : std::nullopt;
  }
  bool is_bound_to_time(std::size_t i) const {
    return std::ranges::any_of(hypothesis(i).names(),
                               [](const std::string& name) { return bound_to(name) == BoundTo::time; });
  }
  /// The strongest interval of each recording in which something acts.
  std::vector<Interval> strongest_by_recording() const {
    std::vector<Interval> result;
    for (const Interval& interval : findings_.located.intervals)
      if (result.size() < kPolicy.compare.most_tugs &&
          std::none_of(result.begin(), result.end(), [&](const Interval& i) { return i.file == interval.file; }))
        result.push_back(interval);
    return result;
  }

  void fit_singles() {
    pairs_.clear();
    selection_.unexcited.clear();
    singles_ = comparison_.expected_gains(0, &selection_.unexcited, is_searched_ ? &pairs_ : nullptr);
    const std::size_t most =
        std::min(singles_.size(), is_searched_ ? options_.refitted : kPolicy.compare.always_refitted);
    for (std::size_t i = 0; i < most; ++i) {
      if (i >= kPolicy.compare.always_refitted && is_hopeless(singles_[i].gain, likeliest_, 0)) break;
      progress(0.45 + 0.25 * static_cast<double>(i) / static_cast<double>(most), "fit with " + singles_[i].effect);
      better(comparison_.add(0, singles_[i].starts));
    }
    for (const auto& single : singles_)
      if (!is_hopeless(comparison_.cost_of_shifts(0), likeliest_, 0))
        better(comparison_.add_as_stated(0, single.starts));
  }

  /// Pairs, from one linear step beside each of the likeliest single effects and beside none, the most promising first.
  void fit_pairs() {
    if (options_.most_effects < 2) return;
    struct Promise {
      std::size_t beside;
      Comparison::ExpectedGain expected;
      double log_odds;
    };
    std::vector<Promise> promises;
    const auto promise = [&](std::size_t beside, std::vector<Comparison::ExpectedGain>& gains) {
      gains.resize(std::min(gains.size(), options_.refitted));
      for (Comparison::ExpectedGain& one : gains) {
        const Hypothesis& both = one.starts.front().hypothesis;
        const double log_odds =
            comparison_.log_odds(beside) + one.gain + log_prior(both) - log_prior(hypothesis(beside));
        promises.push_back({beside, std::move(one), log_odds});
      }
    };
    promise(0, pairs_);
    std::vector<std::size_t> singles;
    bool acts_at_times = false;
    for (std::size_t i = 1; i < comparison_.all().size(); ++i) {
      if (hypothesis(i).names().size() != 1 || has_terms(hypothesis(i).names())) continue;
      // Beside what begins and ends more is sought when it was chosen, in what it leaves.
      if (is_bound_to_time(i))
        acts_at_times |= comparison_.log_odds(i) > 0.0;
      else
        singles.push_back(i);
    }
    std::ranges::sort(singles, std::greater(), [&](std::size_t i) { return comparison_.log_odds(i); });
    singles.resize(std::min(singles.size(), kPolicy.compare.leading_singles));
    for (const std::size_t i : singles) {
      progress(0.735, "what is expected beside " + hypothesis(i).name());
      comparison_.refine_scale(i);
      better(i);
      auto gains = comparison_.expected_gains(i);
      promise(i, gains);
      if (acts_at_times) better(add_in_the_likeliest(i));
    }
    std::ranges::stable_sort(promises, std::greater(), &Promise::log_odds);
    std::size_t fits = 0;
    for (const Promise& one : promises) {
      const double ahead = one.log_odds - comparison_.log_odds(likeliest_);
      const double least = fits < kPolicy.compare.leading_pairs ? -kPolicy.compare.close_odds : 0.0;
      if (fits >= options_.refitted || ahead < least) break;
      progress(0.737, "fit with " + one.expected.starts.front().hypothesis.name());
      const std::size_t known = comparison_.all().size();
      const auto added = comparison_.add(one.beside, one.expected.starts);
      if (!added || *added == known) ++fits;
      better(added);
    }
  }

  void fit_others() {
    fit_places();
    std::vector<Interval> intervals = strongest_by_recording();
    better(intervals.empty() ? add_in_the_likeliest(0, likeliest_)
                             : add_in_intervals(0, std::move(intervals), likeliest_));
    fit_look_alikes();
  }

  /// What surely acts, acts at times, or goes with the position, may be bound to a place, even where one linear step
  /// expects too little of it; else what that step makes likelier than nothing.
  void fit_places() {
    const Located& located = findings_.located;
    std::vector<Interval> events;
    for (const Interval& interval : located.intervals)
      if (interval.p_value < options_.locate.false_alarm) events.push_back(interval);
    const bool may_act = !events.empty() || errs_grossly(findings_.fit) ||
                         findings_.detection.p_value < surely(options_.locate.false_alarm) ||
                         std::ranges::any_of(located.frames, [](const Frame& frame) {
                           return frame.is_of_place && frame.log_evidence > kPolicy.compare.position_evidence;
                         });
    progress(0.73, "banks, fenders, moorings");
    for (const auto& candidate : comparison_.expected_gains_of_places(0, events))
      if ((may_act || candidate.gain + log_prior_odds_of_one(0) > 0.0) &&
          !is_hopeless(candidate.gain, likeliest_, 0, kPolicy.compare.hopeless_share_of_places))
        better(comparison_.add(0, candidate.starts, kPolicy.compare.starts_of_places));
  }

  /// One step expected_gains too little of what gains by another model error: what the likeliest is said to look like
  /// is tried as well.
  void fit_look_alikes() {
    for (std::size_t of = 0; of != likeliest_;) {
      of = likeliest_;
      const std::vector<std::string> names = hypothesis(of).names();
      for (const auto& candidate : singles_)
        if (names.size() == 1 && are_look_alikes(names.front(), candidate.effect) &&
            !is_hopeless(candidate.gain, of, 0, kPolicy.compare.hopeless_share,
                         kPolicy.compare.far_behind_of_look_alikes))
          better(comparison_.add(0, candidate.starts));
    }
  }

  void fit_terms() {
    progress(0.74, "terms of what the catalogue does not hold");
    const std::vector<Start> terms = terms_beside(campaign_, comparison_.all()[0], options_.locate.jobs);
    if (!is_hopeless(expected_of(terms, 0), likeliest_, 0)) better(comparison_.add(0, terms));
  }

  /// What the catalogue does not hold, but is known by what it depends on; if its odds are rare, all names beside.
  void find_latent() {
    progress(0.745, "forces that the catalogue does not hold");
    find_kinds_beside(0);
    selection_.latent_log_evidence = log_evidence_of(selection_.latent);
    selection_.latent_log_odds = log_odds_of(selection_.latent);
    if (is_searched_ || !is_rare(latent(), options_.locate.false_alarm)) return;
    search();
  }
  LatentFound latent() const {
    double names = 0.0;  // by the likeliest's odds
    const double most = comparison_.log_odds(likeliest_);
    for (std::size_t i = 1; i < comparison_.all().size(); ++i)
      if (!has_terms(hypothesis(i).names())) names += std::exp(comparison_.log_odds(i) - most);
    return {selection_.latent_log_evidence, selection_.latent_log_odds, most + std::log(names), selection_.error,
            findings_.tests};
  }

  /// That, where it is likelier than all names together; the chosen ones only where they hold beside it.
  void take_latent() {
    const std::size_t chosen = selection_.chosen;
    selection_.is_latent = is_claimed(latent(), options_.locate.false_alarm);
    if (!selection_.is_latent || chosen == 0) return;
    const std::vector<LatentForce> alone = selection_.latent;
    find_kinds_beside(chosen);
    const std::vector<std::string> names = hypothesis(chosen).names();
    LatentFound both = latent();
    both.log_odds_with_chosen = comparison_.log_odds(chosen) + log_odds_of(selection_.latent, names.size());
    if (!has_terms(names) && holds_beside(both, options_.locate.false_alarm)) return;
    selection_.chosen = 0;
    selection_.latent = alone;
  }

  /// Latent forces beside a fit; terms, where they were fitted, are another form of what depends on states.
  void find_kinds_beside(std::size_t i) {
    auto known = latent_beside_.find(i);
    if (known == latent_beside_.end())
      known = latent_beside_.emplace(i, latent_forces(campaign_, comparison_.all()[i].fit, options_.locate.jobs)).first;
    selection_.latent = known->second;
    std::set<std::string> bare = name_set(hypothesis(i));
    bare.erase(name_of_terms());
    if (const auto gain = gain_of_terms(comparison_.all(), bare))
      add_kind({Dependence::states, {0, 1, 2}, kMissing, false, {}, *gain});
  }

  /// Kinds of what may be left beside what was chosen, with what intervals stand for.
  void describe_unknown() {
    const std::size_t chosen = selection_.chosen;
    if (chosen != 0) {
      selection_.latent.clear();
      if (!selection_.is_latent && !has_terms(hypothesis(chosen).names()) &&
          selection_.left_p_value > surely_beside(options_.locate.false_alarm))
        return;
      find_kinds_beside(chosen);
    }
    const std::vector<Interval>& intervals = findings_.located.intervals;
    const auto strongest = std::ranges::min_element(intervals, {}, &Interval::p_value);
    if (strongest == intervals.end()) return;
    // What comes and goes is an event to the fit, and costs what events cost there.
    const bool has_events = comparison_.all()[chosen].fit.log_prior_of_events < 0.0;
    const double gain = has_events ? 0.0 : -std::log(least_odds_of_nothing(strongest->p_value));
    add_kind({Dependence::time, {strongest->axis}, kMissing, false, {}, gain});
  }

  /// Of one kind the likelier.
  void add_kind(LatentForce kind) {
    std::vector<LatentForce>& kinds = selection_.latent;
    const auto same = std::ranges::find(kinds, kind.on, &LatentForce::on);
    if (same == kinds.end())
      kinds.push_back(std::move(kind));
    else if (same->log_evidence < kind.log_evidence)
      *same = std::move(kind);
    std::ranges::stable_sort(kinds, std::greater(), &LatentForce::log_evidence);
  }

  /// Those that are about as likely as the likeliest are compared where none gains any more.
  void refine_the_likeliest() {
    std::vector<std::size_t> close;
    if (likeliest_ == 0) return;
    for (std::size_t i = 1; i < comparison_.all().size(); ++i)
      if (comparison_.log_odds(i) > comparison_.log_odds(likeliest_) - kPolicy.compare.close_odds) close.push_back(i);
    if (close.size() < 2) return;
    for (const std::size_t i : close) comparison_.refine(i);
  }

  /// Of all, the one that will be stated as likeliest, if it predicts better what was left out.
  void take_likeliest() {
    refine_the_likeliest();
    selection_.stated = comparison_.probabilities();
    const std::vector<double>& stated = selection_.stated;
    const double p_value = findings_.detection.p_value;
    std::size_t& best = selection_.best;
    const double rate = options_.locate.false_alarm;
    const auto may_be = [&](std::size_t i) {
      return may_be_claimed({has_terms(hypothesis(i).names()), comparison_.log_odds(i), selection_.error, p_value},
                            rate);
    };
    // Of single ones; then what is likelier and holds against it, though it need not be in it.
    const auto is_single = [&](std::size_t i) { return hypothesis(i).names().size() == 1; };
    for (std::size_t i = 1; i < stated.size(); ++i)
      if (is_single(i) && (best == 0 || stated[i] > stated[best]) && may_be(i)) best = i;
    std::vector<std::size_t> likelier;
    for (std::size_t i = 1; i < stated.size(); ++i)
      if (!is_single(i) && stated[i] > stated[best] && may_be(i)) likelier.push_back(i);
    std::ranges::sort(likelier, std::greater(), [&](std::size_t i) { return stated[i]; });
    const auto holds = std::ranges::find_if(likelier, [&](std::size_t i) { return comparison_.holds(i, best, false); });
    if (holds != likelier.end()) best = *holds;
    Likeliest likeliest{stated[best], 0.0, kPolicy.decide.families * comparison_.chance_of(best)};
    for (std::size_t i = 1; i < stated.size(); ++i)
      if (!may_be(i)) likeliest.of_other_forms = std::max(likeliest.of_other_forms, stated[i]);
    if (is_certain(likeliest, rate) && comparison_.holds(best, 0, p_value < rate)) selection_.chosen = best;
    if (selection_.chosen == 0) selection_.left_p_value = p_value;
  }

  /// Effects beside what was chosen, as long as something is left.
  void take_more() {
    std::size_t& chosen = selection_.chosen;
    double& left_p = selection_.left_p_value;
    while (chosen != 0) {
      const std::size_t size = hypothesis(chosen).names().size();
      progress(0.75 + 0.04 * static_cast<double>(size), "what is left beside " + hypothesis(chosen).name());
      comparison_.refine(chosen);
      const Left left = left_beside(campaign_, comparison_.all()[chosen], options_);
      left_p = left.p_value;
      std::vector<Interval> intervals;
      if (left.interval.interval) intervals.push_back(*left.interval.interval);
      selection_.error = error_of(comparison_.all()[chosen].fit.noise.sigma_w, intervals);
      if (size >= options_.most_effects) break;
      const double rate = options_.locate.false_alarm;
      std::optional<std::size_t> next;
      auto candidates = comparison_.expected_gains(chosen);
      candidates.resize(std::min(candidates.size(), kPolicy.compare.next_refitted));
      for (const auto& candidate : candidates) {
        // A p-value is against everything that may be left; one effect may be certain by itself.
        const bool may_be_likelier = candidate.gain + log_prior_odds_of_one(size) > 0.0;
        if (is_hopeless(candidate.gain, next, chosen) || !(left_p < rate || may_be_likelier)) break;
        if (const auto added = comparison_.add(chosen, candidate.starts))
          if (!next || evidence(*added) > evidence(*next)) next = added;
      }
      if (!is_bound_to_time(chosen))
        if (const auto added = add_in_the_likeliest(chosen))
          if (!next || evidence(*added) > evidence(*next)) next = added;
      LeftBeside beside{left_p, evidence(chosen) - evidence(0), selection_.error, std::nullopt};
      if (next) beside.log_odds_of_next = comparison_.log_odds(*next) - comparison_.log_odds(chosen);
      selection_.is_negligible = is_negligible(beside, rate);
      if (!next || !comparison_.holds(*next, chosen, left_p < surely(rate))) break;
      if (!(left_p < rate || comparison_.is_rare(*next, chosen) || comparison_.is_likelier_than_not(*next))) break;
      chosen = *next;
      selection_.is_negligible = false;
    }
  }

  /// What the catalogue does not hold beside what was chosen, in a few terms.
  void take_terms() {
    const std::size_t chosen = selection_.chosen;
    const LeftBeside left{selection_.left_p_value, 0.0, selection_.error, std::nullopt};
    if (chosen == 0 || has_terms(hypothesis(chosen).names()) ||
        !may_have_terms(left, selection_.is_negligible, options_.locate.false_alarm))
      return;
    progress(0.86, "terms for what is left");
    const auto added =
        comparison_.add(chosen, terms_beside(campaign_, comparison_.all()[chosen], options_.locate.jobs));
    if (!added || !comparison_.holds(*added, chosen, selection_.left_p_value < surely(options_.locate.false_alarm)) ||
        comparison_.log_odds(*added) <= comparison_.log_odds(selection_.best))
      return;
    selection_.chosen = *added;
    selection_.left_p_value = left_beside(campaign_, comparison_.all()[*added], options_).p_value;
  }

  /// Of several effects that seem needless beside the others the one goes without which the rest is likeliest.
  void drop_needless() {
    std::size_t& chosen = selection_.chosen;
    while (chosen != 0) {
      const std::vector<std::string> names = hypothesis(chosen).names();
      if (names.size() < 2 || has_terms(names)) return;
      std::optional<std::size_t> shorter;
      for (std::size_t out = 0; out < names.size(); ++out) {
        std::optional<std::size_t> reduced = std::size_t{0};
        for (std::size_t i = 0; i < names.size() && reduced; ++i) {
          if (i == out) continue;
          const std::vector<Start> starts = starts_with(*reduced, names[i]);
          const bool is_far_behind = is_hopeless(expected_of(starts, *reduced), chosen, *reduced);
          reduced = is_far_behind ? std::nullopt : comparison_.add(*reduced, starts);
        }
        if (reduced && *reduced != 0 && !comparison_.holds(chosen, *reduced, false) &&
            (!shorter || comparison_.log_odds(*reduced) > comparison_.log_odds(*shorter)))
          shorter = reduced;
      }
      if (!shorter) return;
      chosen = *shorter;
    }
  }

  const Campaign& campaign_;
  const Findings& findings_;
  Comparison& comparison_;
  const GapExplainOptions& options_;
  bool is_searched_;  // not only a few, to know that nothing is likelier than them
  std::size_t likeliest_ = 0;
  std::vector<Comparison::ExpectedGain> singles_, pairs_;
  std::vector<Interval> intervals_;                                ///< in which effects that begin and end were sought
  std::map<std::size_t, std::vector<LatentForce>> latent_beside_;  ///< fits
  Selection selection_;
};

}  // namespace

Selection select(const Campaign& campaign, const Findings& findings, Comparison& comparison,
                 const GapExplainOptions& options) {
  return Selector(campaign, findings, comparison, options).run();
}

}  // namespace leeway::gap
