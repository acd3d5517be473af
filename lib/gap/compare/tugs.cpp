#include "gap/compare/tugs.hpp"

#include <algorithm>
#include <cmath>
#include <map>

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

Candidate tug_in(const Campaign& campaign, const Fitted& fitted, const std::string& effect, const Interval& interval,
                 std::size_t jobs) {
  const Timed timed(effect_named(effect));
  FreeEffect::Choice choice;
  choice.freed = {timed.lever};
  choice.log_ways = std::log(static_cast<double>(interval.searched)) +
                    2.0 * std::log(kPolicy.compare.first_shift_s / kPolicy.compare.last_shift_s);
  double from_s = interval.t_start_s, until_s = interval.t_end_s;  // of the stretch
  for (const Stretch& stretch : campaign.stretches)
    if (campaign.recordings[stretch.recording].file == interval.file && stretch.t_s.front() <= interval.t_start_s &&
        interval.t_start_s <= stretch.t_s.back()) {
      from_s = stretch.t_s.front(), until_s = stretch.t_s.back();
      if (campaign.recordings.size() > 1) choice.recording = stretch.recording;
    }
  const auto best_of = [&](const std::vector<Candidate>& candidates) {
    const EffectScreen screen = screen_of(campaign, fitted, candidates, {jobs, false});
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
  choice.fixed = {{timed.begin, begin_s}, {timed.end, end_s}};
  Start best = best_of(candidates_of(effect, campaign.ship, {choice}));
  const double scale = campaign.time_scale();
  double shift_s = kPolicy.compare.first_shift_s * scale;
  for (int i = 0; i < kPolicy.compare.most_shifts && shift_s >= kPolicy.compare.last_shift_s * scale; ++i) {
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
    best = best_of(candidates);
    const std::vector<double> now = best.hypothesis.effects.back().values(z);
    const double begin = now[timed.begin_place], end = now[timed.end_place];
    const bool is_unchanged =
        std::abs(begin - begin_s) < kPolicy.compare.same_time_s && std::abs(end - end_s) < kPolicy.compare.same_time_s;
    begin_s = begin, end_s = end;
    if (is_unchanged) shift_s *= 0.5;
  }
  return {{best.hypothesis.effects.back()}, z_of(best)};
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
  struct Piece {
    std::size_t tug;
    std::string end;
    double time_s;
  };
  for (int round = 0; round < kPolicy.compare.most_shifts; ++round) {
    std::vector<Candidate> candidates;
    std::vector<Piece> pieces;
    const Coordinates z = coordinates_of(fitted.fit);
    Eigen::Index at = 0;
    for (std::size_t i = 0; i < fitted.hypothesis.effects.size(); ++i) {
      const FreeEffect& tug = fitted.hypothesis.effects[i];
      const std::vector<double> now = tug.values(z.mean.segment(at, tug.size()));
      at += tug.size();
      if (bound_to(tug.name()) != BoundTo::time) continue;
      const EffectDescription& description = effect_named(tug.name());
      const Timed timed(description);
      FreeEffect::Choice choice;
      choice.recording = tug.recording();
      for (std::size_t p = 0; p < now.size(); ++p) choice.fixed[std::string(description.parameters[p].name)] = now[p];
      const double force = now[timed.force_place], begin = now[timed.begin_place], end = now[timed.end_place];
      for (const double shift : kPolicy.compare.refined_shifts)
        for (const bool at_end : {false, true}) {
          const double before = at_end ? end : begin,
                       after = before + shift * kPolicy.compare.last_shift_s * campaign.time_scale();
          if ((at_end ? after - begin : end - after) < shortest_s(campaign)) continue;
          choice.fixed[timed.begin] = std::min(before, after);
          choice.fixed[timed.end] = std::max(before, after);
          choice.fixed[timed.force] = (after > before) == at_end ? force : -force;
          candidates.push_back({{FreeEffect(tug.name(), campaign.ship, choice)}, Eigen::VectorXd()});
          pieces.push_back({i, at_end ? timed.end : timed.begin, after});
        }
    }
    if (candidates.empty()) return;
    const EffectScreen screen(campaign, fitted.fit, fitted.hypothesis, candidates, 1.0, {{.prior = fitted.fit.prior}},
                              {options.jobs});
    std::map<std::pair<std::size_t, std::string>, std::pair<double, double>> best;  // gain and time
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      auto& [gain, time_s] = best[{pieces[c].tug, pieces[c].end}];
      const double gains = screen.log_evidence({c}) - screen.log_evidence({});
      if (gains > std::max(gain, kPolicy.compare.converged_gain)) gain = gains, time_s = pieces[c].time_s;
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
