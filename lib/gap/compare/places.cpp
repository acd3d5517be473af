#include "gap/compare/places.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

Prior about(double median, double sd, double low = -std::numeric_limits<double>::infinity()) {
  return normal(median, sd, std::max(low, median - kPolicy.compare.prior_reach_sd * sd),
                median + kPolicy.compare.prior_reach_sd * sd);
}

// How far the hull, a box, reaches in a direction.
double reach_of(const Vec6& measured, const Vec2<double>& towards, const Particulars& ship) {
  const double along = towards(0) * std::cos(measured(2)) + towards(1) * std::sin(measured(2)),
               across = towards(1) * std::cos(measured(2)) - towards(0) * std::sin(measured(2)),
               half = 0.5 * ship.L_pp * std::abs(along) + 0.5 * ship.B * std::abs(across);
  return measured.head<2>().dot(towards) + (std::isnan(half) ? 0.5 * ship.B : half);
}

// Where the ship was measured, and whether something acted about then.
struct Visited {
  std::vector<Vec6> places;
  std::vector<bool> in_event;
};

Visited visited_by(const Campaign& campaign, const std::vector<Interval>& events) {
  Visited visited;
  for (const Stretch& stretch : campaign.stretches)
    for (std::size_t k = 0; k < stretch.size(); ++k) {
      if (!stretch.measured[k].head<2>().allFinite()) continue;
      visited.places.push_back(stretch.measured[k]);
      visited.in_event.push_back(std::any_of(events.begin(), events.end(), [&](const Interval& event) {
        const double around_s = event.t_end_s - event.t_start_s;
        return event.file == campaign.recordings[stretch.recording].file &&
               event.t_start_s - around_s <= stretch.t_s[k] && stretch.t_s[k] <= event.t_end_s + around_s;
      }));
    }
  return visited;
}

// Points about the tracks to which a line may go, taut at any length or beyond some slack.
std::vector<FreeEffect::Choice> anchors_about(const std::vector<Vec6>& visited, const EffectDescription& effect,
                                              double L_pp) {
  const std::string anchor_x = name_of(ParameterRole::anchor_x, effect),
                    anchor_y = name_of(ParameterRole::anchor_y, effect),
                    slack_length = name_of(ParameterRole::slack, effect);
  std::vector<FreeEffect::Choice> result;
  Vec2<double> low = visited.front().head<2>(), high = low;
  for (const Vec6& place : visited) low = low.cwiseMin(place.head<2>()), high = high.cwiseMax(place.head<2>());
  const Vec2<double> middle = 0.5 * (low + high),
                     half = 0.5 * (high - low) + Vec2<double>::Constant(kPolicy.compare.anchor_lengths * L_pp);
  for (std::int64_t i = -kPolicy.compare.anchors; i <= kPolicy.compare.anchors; ++i)
    for (std::int64_t j = -kPolicy.compare.anchors; j <= kPolicy.compare.anchors; ++j) {
      const Vec2<double> anchor =
          middle + Vec2<double>(static_cast<double>(i), static_cast<double>(j)).cwiseProduct(half) /
                       static_cast<double>(kPolicy.compare.anchors);
      double farthest = 0.0;
      for (const Vec6& place : visited) farthest = std::max(farthest, (place.head<2>() - anchor).norm());
      FreeEffect::Choice choice;
      choice.priors = {{anchor_x, about(anchor(0), half(0))}, {anchor_y, about(anchor(1), half(1))}};
      result.push_back(choice);
      choice.freed = {slack_length};
      for (const double slack : kPolicy.compare.line_slacks) {
        choice.priors[slack_length] = about(slack * farthest, kPolicy.compare.slack_sd * farthest, 0.0);
        result.push_back(choice);
      }
    }
  return result;
}

// Walls in all directions: beside the tracks, or where the hull touches them somewhere.
std::vector<FreeEffect::Choice> walls_about(const Visited& visited, const EffectDescription& effect,
                                            const Particulars& ship) {
  const bool is_touched = effect.info.search == SearchStart::contact;
  const std::string distance = name_of(ParameterRole::wall_distance, effect);
  std::vector<FreeEffect::Choice> result;
  const auto add = [&](double towards_deg, double median) {
    FreeEffect::Choice choice;
    choice.towards_deg = towards_deg;
    choice.priors = {{distance, about(median, kPolicy.compare.wall_beams * ship.B)}};
    result.push_back(std::move(choice));
  };
  const std::int64_t every = kPolicy.compare.fine_directions /
                             (is_touched ? kPolicy.compare.fender_directions : kPolicy.compare.bank_directions);
  for (std::int64_t k = 0; k < kPolicy.compare.fine_directions; ++k) {
    const double angle = 2.0 * kPi * static_cast<double>(k) / static_cast<double>(kPolicy.compare.fine_directions);
    const Vec2<double> towards{std::cos(angle), std::sin(angle)};
    double midship = -std::numeric_limits<double>::infinity(), hull = midship;
    bool acts_there = false;  // where the hull reaches farthest
    for (std::size_t i = 0; i < visited.places.size(); ++i) {
      midship = std::max(midship, visited.places[i].head<2>().dot(towards));
      if (const double reach = reach_of(visited.places[i], towards, ship); reach > hull)
        hull = reach, acts_there = visited.in_event[i];
    }
    if (k % every != 0 && !acts_there) continue;
    if (is_touched)
      for (const double depth : kPolicy.compare.fender_depths) add(angle / kDegree, hull - depth * ship.L_pp);
    else
      add(angle / kDegree, midship + kPolicy.compare.wall_beams * ship.B);
  }
  return result;
}

}  // namespace

std::vector<FreeEffect::Choice> places_of(const std::string& effect, const Campaign& campaign,
                                          const std::vector<Interval>& events) {
  const Visited visited = visited_by(campaign, events);
  if (visited.places.empty()) return {};
  const EffectDescription& description = effect_named(effect);
  const Particulars& ship = campaign.ship.particulars;
  return description.info.search == SearchStart::anchor ? anchors_about(visited.places, description, ship.L_pp)
                                                        : walls_about(visited, description, ship);
}

void keep_apart(std::vector<Start>& starts) {
  std::vector<Start> kept;
  for (Start& start : starts) {
    const double towards_deg = start.hypothesis.effects.back().towards_deg();
    if (std::none_of(kept.begin(), kept.end(), [&](const Start& other) {
          const double apart_deg = towards_deg - other.hypothesis.effects.back().towards_deg();
          return std::abs(wrap_angle(apart_deg * kDegree)) < kPolicy.compare.apart_deg * kDegree;
        }))
      kept.push_back(std::move(start));
  }
  starts = std::move(kept);
}

void take_turns(std::vector<Start>& starts) {
  std::map<Eigen::Index, std::size_t> so_far;
  std::vector<std::pair<std::size_t, Start>> turns;
  for (Start& start : starts) {
    const std::size_t turn = so_far[start.hypothesis.size()]++;
    turns.emplace_back(turn, std::move(start));
  }
  std::ranges::stable_sort(turns, {}, &std::pair<std::size_t, Start>::first);
  starts.clear();
  for (auto& [turn, start] : turns) starts.push_back(std::move(start));
}

}  // namespace leeway::gap
