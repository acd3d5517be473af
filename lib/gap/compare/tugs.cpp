#include "gap/compare/tugs.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "core/errors.hpp"
#include "gap/compare/candidates.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// Parameters of an effect that begins and ends, by name and place.
struct Timed {
  std::string lever, force, begin, end;
  std::size_t force_place, begin_place, end_place;

  explicit Timed(const EffectDescription& effect)
      : lever(name_of(ParameterRole::lever, effect)),
        force(name_of(ParameterRole::force, effect)),
        begin(name_of(ParameterRole::begin, effect)),
        end(name_of(ParameterRole::end, effect)),
        force_place(place_of(ParameterRole::force, effect)),
        begin_place(place_of(ParameterRole::begin, effect)),
        end_place(place_of(ParameterRole::end, effect)) {}
};

// What acts for less than a block of time looks like an outlying measurement.
double shortest_s(const Campaign& campaign) { return kPolicy.locate.block_s * campaign.time_scale(); }

double last_shift_s(const Campaign& campaign) { return kPolicy.compare.last_shift_s * campaign.time_scale(); }

// The first and the last time of the stretch in which something begins.
std::pair<double, double> bounds_s(const Campaign& campaign, std::size_t recording, double begin_s) {
  for (const Stretch& stretch : campaign.stretches)
    if (stretch.recording == recording && stretch.t_s.front() <= begin_s && begin_s <= stretch.t_s.back())
      return {stretch.t_s.front(), stretch.t_s.back()};
  return {begin_s, begin_s};
}

// ln of the area of all begins and ends that may be [s^2], which are believed alike.
double log_area(const Campaign& campaign) {
  double area = 0.0;
  for (const Stretch& stretch : campaign.stretches) {
    const double longest = stretch.t_s.back() - stretch.t_s.front() - shortest_s(campaign);
    if (longest > 0.0) area += 0.5 * longest * longest;
  }
  return std::log(std::max(area, last_shift_s(campaign) * last_shift_s(campaign)));
}

// What recordings say of a begin or an end: ln of the evidence by its shift from where it is [s], 0 there.
using EvidenceByShift = std::map<double, double>;

struct KnownTime {
  double log_width_s = 0.0;  ///< ln of the integral of the evidence, by trapezoids
  double sd_s = 0.0;         ///< root mean square of the shift
};
KnownTime known_time(const EvidenceByShift& by_shift) {
  const double most = std::ranges::max_element(by_shift, {}, &EvidenceByShift::value_type::second)->second;
  double sum = 0.0, sum_of_squares = 0.0;
  for (auto after = std::next(by_shift.begin()); after != by_shift.end(); ++after) {
    const auto before = std::prev(after);
    for (const auto& [shift_s, log_evidence] : {*before, *after}) {
      const double area = 0.5 * (after->first - before->first) * std::exp(log_evidence - most);
      sum += area;
      sum_of_squares += area * shift_s * shift_s;
    }
  }
  return {most + std::log(sum), std::sqrt(sum_of_squares / sum)};
}

Candidate tug_in(const Campaign& campaign, const Fitted& fitted, const std::string& effect, const Interval& interval,
                 std::size_t jobs) {
  const Timed timed(effect_named(effect));
  FreeEffect::Choice choice;
  choice.freed = {timed.lever};
  const auto is_its = [&](const Trajectory& recording) { return recording.file == interval.file; };
  const auto recording =
      static_cast<std::size_t>(std::ranges::find_if(campaign.recordings, is_its) - campaign.recordings.begin());
  const auto [from_s, until_s] = bounds_s(campaign, recording, interval.t_start_s);
  if (campaign.recordings.size() > 1) choice.recording = recording;
  choice.log_ways = log_area(campaign) - 2.0 * std::log(last_shift_s(campaign));  // until known_time says less
  const auto starts_from = [&](const std::vector<Candidate>& candidates) {
    const EffectScreen screen = screen_of(campaign, fitted, candidates, {jobs, false});
    std::vector<Start> starts;
    for (std::size_t c = 0; c < candidates.size(); ++c) starts.push_back(screen.start({c}));
    sort(starts);
    return starts;
  };
  const auto z_of = [](const Start& start) -> Eigen::VectorXd {
    const Eigen::Index size = start.hypothesis.effects.back().size();
    return start.theta.segment(start.theta.size() - 1 - size, size);
  };
  double begin_s = interval.t_start_s, end_s = interval.t_end_s;
  choice.fixed = {{timed.begin, begin_s}, {timed.end, end_s}};
  // A linear step from the opposite direction promises as much, by a force below zero; the next one, from where that
  // led, does not. So the worse half is left out after each step.
  std::vector<Start> around = starts_from(candidates_of(effect, campaign.ship, {choice}));
  while (around.size() > 1) {
    around.resize((around.size() + 1) / 2);
    std::vector<Candidate> candidates;
    candidates.reserve(around.size());
    for (const Start& start : around) candidates.push_back({{start.hypothesis.effects.back()}, z_of(start)});
    around = starts_from(candidates);
  }
  Start best = around.front();
  double shift_s = kPolicy.compare.first_shift_s * campaign.time_scale();
  for (int i = 0; i < kPolicy.compare.most_shifts && shift_s >= last_shift_s(campaign); ++i) {
    FreeEffect tug = best.hypothesis.effects.back();
    const Eigen::VectorXd z = z_of(best);
    std::vector<Candidate> candidates;
    for (const double a : {0.0, -1.0, 1.0})
      for (const double b : {0.0, -1.0, 1.0}) {
        const double begin = std::max(from_s, begin_s + a * shift_s), end = std::min(until_s, end_s + b * shift_s);
        if (end - begin < shortest_s(campaign)) continue;
        tug.fix(timed.begin, begin);
        tug.fix(timed.end, end);
        candidates.push_back({{tug}, z});
      }
    if (candidates.empty()) break;
    best = starts_from(candidates).front();
    const std::vector<double> now = best.hypothesis.effects.back().values(z);
    const double begin = now[timed.begin_place], end = now[timed.end_place];
    const bool is_unchanged =
        std::abs(begin - begin_s) < kPolicy.compare.same_time_s && std::abs(end - end_s) < kPolicy.compare.same_time_s;
    begin_s = begin, end_s = end;
    if (is_unchanged) shift_s *= 0.5;
  }
  return {{best.hypothesis.effects.back()}, z_of(best)};
}

// Begins and ends of what is fitted, by place of the effect in the hypothesis and name of the parameter.
using EndOf = std::pair<std::size_t, std::string>;

// By one linear step beside a fit: pieces with the force of a tug, or against it, at each of its ends.
std::map<EndOf, EvidenceByShift> shifted_ends(const Campaign& campaign, const Fitted& fitted, std::size_t jobs) {
  std::vector<Candidate> pieces;
  std::vector<std::pair<EndOf, double>> shifts;
  std::map<EndOf, EvidenceByShift> result;
  const Coordinates z = coordinates_of(fitted.fit);
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < fitted.hypothesis.effects.size(); ++i) {
    const FreeEffect& tug = fitted.hypothesis.effects[i];
    const std::vector<double> now = tug.values(z.mean.segment(at, tug.size()));
    at += tug.size();
    if (bound_to(tug.name()) != BoundTo::time) continue;
    const EffectDescription& description = effect_named(tug.name());
    const Timed timed(description);
    FreeEffect::Choice piece;
    piece.recording = tug.recording();
    for (std::size_t p = 0; p < now.size(); ++p) piece.fixed[std::string(description.parameters[p].name)] = now[p];
    const double force = now[timed.force_place], begin_s = now[timed.begin_place], end_s = now[timed.end_place];
    const auto [from_s, until_s] = bounds_s(campaign, tug.recording().value_or(0), begin_s);
    for (const bool is_end : {false, true}) {
      const EndOf end{i, is_end ? timed.end : timed.begin};
      result[end][0.0] = 0.0;
      for (const double shift : kPolicy.compare.refined_shifts) {
        const double shift_s = shift * last_shift_s(campaign), before_s = is_end ? end_s : begin_s,
                     after_s = before_s + shift_s;
        if (after_s < from_s || after_s > until_s) continue;
        if ((is_end ? after_s - begin_s : end_s - after_s) < shortest_s(campaign)) continue;
        piece.fixed[timed.begin] = std::min(before_s, after_s);
        piece.fixed[timed.end] = std::max(before_s, after_s);
        piece.fixed[timed.force] = (after_s > before_s) == is_end ? force : -force;
        pieces.push_back({{FreeEffect(tug.name(), campaign.ship, piece)}, Eigen::VectorXd()});
        shifts.emplace_back(end, shift_s);
      }
    }
  }
  const EffectScreen screen(campaign, fitted.fit, fitted.hypothesis, pieces, 1.0, {{.prior = fitted.fit.prior}},
                            {jobs});
  for (std::size_t c = 0; c < shifts.size(); ++c)
    result[shifts[c].first][shifts[c].second] = screen.log_evidence({c}) - screen.log_evidence({});
  return result;
}

// Where begins and ends are, what is known of them, and what that costs of all that may be.
void take_known_times(const Campaign& campaign, const std::map<EndOf, EvidenceByShift>& ends, Fitted& fitted) {
  const double of_all = log_area(campaign);
  std::map<std::size_t, double> log_ways;
  for (const auto& [end, by_shift] : ends) {
    if (by_shift.size() < 2) continue;
    const KnownTime known = known_time(by_shift);
    fitted.hypothesis.effects[end.first].know(end.second, known.sd_s);
    log_ways.try_emplace(end.first, of_all).first->second -= known.log_width_s;
  }
  for (const auto& [tug, ways] : log_ways) fitted.hypothesis.effects[tug].choose_from(std::max(0.0, ways));
}

}  // namespace

std::vector<Start> starts_in_intervals(const Campaign& campaign, const Fitted& fitted, const std::string& effect,
                                       const std::vector<Interval>& intervals, std::size_t jobs) {
  std::vector<Candidate> tugs;
  std::vector<std::size_t> all;
  for (const Interval& interval : intervals) {
    all.push_back(tugs.size());
    tugs.push_back(tug_in(campaign, fitted, effect, interval, jobs));
    tugs.back().effects.front().count_from(tugs.front().effects.front().towards_deg(), tugs.back().z);
  }
  return {screen_of(campaign, fitted, std::move(tugs), {jobs, false}).start(all)};
}

void refine_tugs(const Campaign& campaign, const FitOptions& options, Fitted& fitted) {
  for (int round = 0; round < kPolicy.compare.most_shifts; ++round) {
    const auto ends = shifted_ends(campaign, fitted, options.jobs);
    take_known_times(campaign, ends, fitted);
    Fitted next = fitted;
    bool moves = false;
    for (const auto& [end, by_shift] : ends) {
      const auto best = std::ranges::max_element(by_shift, {}, &EvidenceByShift::value_type::second);
      if (best->second <= kPolicy.compare.converged_gain) continue;
      next.hypothesis.effects[end.first].shift(end.second, best->first);
      moves = true;
    }
    if (!moves) return;
    try {
      next.fit = fit_with(campaign, fitted.fit, next.hypothesis, fitted.fit.theta, options);
    } catch (const NumericalError&) {
      return;
    }
    next.log_evidence = gap::log_evidence(next.fit);
    if (next.log_evidence < fitted.log_evidence + kPolicy.compare.converged_gain) return;
    fitted = std::move(next);
  }
}

}  // namespace leeway::gap
