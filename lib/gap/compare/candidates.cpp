#include "gap/compare/candidates.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "gap/compare/current_course.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

std::vector<Candidate> candidates_with(const Campaign& campaign, const std::string& effect,
                                       const FreeEffect::Choice& chosen) {
  const FreeEffect::Choice choice = search_start(effect) == SearchStart::course ? current_course(campaign) : chosen;
  std::set<std::size_t> recordings;
  for (const Stretch& stretch : campaign.stretches) recordings.insert(stretch.recording);
  try {
    std::vector<Candidate> result = candidates_of(effect, campaign.ship, {choice});
    if (effect_named(effect).info.differs_by_recording && !choice.recording && recordings.size() > 1 &&
        recordings.size() <= kPolicy.compare.most_that_differ)
      for (const std::size_t recording : recordings) {
        FreeEffect::Choice there = choice;
        there.recording = recording;
        for (Candidate& candidate : candidates_of(effect, campaign.ship, {there}))
          result.push_back(std::move(candidate));
      }
    return result;
  } catch (const EffectNotApplicable&) {
    return {};
  }
}

namespace {

// Candidates of one effect that act in one recording alone, by recording.
using ByRecording = std::map<std::size_t, std::vector<std::size_t>>;

// Of each recording the candidate with which all together are likeliest: first that which is likeliest alone, then
// beside those of the others. As long as they are missing, coefficients take their part.
std::vector<std::size_t> likeliest_together(const EffectScreen& screen, const ByRecording& by_recording) {
  std::vector<std::size_t> together;
  together.reserve(by_recording.size());
  for (const auto& [recording, candidates] : by_recording)
    together.push_back(
        *std::ranges::max_element(candidates, {}, [&](std::size_t c) { return screen.log_evidence({c}); }));
  double most = screen.log_evidence(together);
  for (bool is_better = true; is_better;) {
    is_better = false;
    std::size_t place = 0;
    for (const auto& [recording, candidates] : by_recording) {
      std::vector<std::size_t> tried = together;
      for (const std::size_t c : candidates) {
        tried[place] = c;
        const double evidence = screen.log_evidence(tried);
        if (!(evidence > most)) continue;
        most = evidence;
        together = tried;
        is_better = true;
      }
      ++place;
    }
  }
  return together;
}

// Coordinates of the effect at `place` of a set, after the step from where it is tried.
Eigen::VectorXd coordinates_at(const EffectScreen& screen, const std::vector<std::size_t>& set, std::size_t place) {
  const Start start = screen.start(set);
  Eigen::Index first = start.theta.size() - 1;  // the last one is the timing
  for (std::size_t i = set.size(); i-- > place;) first -= screen.candidates()[set[i]].effects.front().size();
  return start.theta.segment(first, screen.candidates()[set[place]].effects.front().size());
}

// The likeliest set that differs in the recording at `place`, where it goes the opposite way; empty if none does.
std::vector<std::size_t> with_opposite(const EffectScreen& screen, const std::vector<std::size_t>& set,
                                       std::size_t place, const std::vector<std::size_t>& candidates) {
  const Eigen::VectorXd here = coordinates_at(screen, set, place);
  std::vector<std::size_t> tried = set, opposite;
  double best = -std::numeric_limits<double>::infinity();
  for (const std::size_t c : candidates) {
    tried[place] = c;
    const double evidence = screen.log_evidence(tried);
    if (!(evidence > best) || coordinates_at(screen, tried, place).dot(here) >= 0.0) continue;
    best = evidence;
    opposite = tried;
  }
  return opposite;
}

}  // namespace

std::vector<std::vector<std::size_t>> sets_of(const EffectScreen& screen, std::size_t begin, std::size_t end,
                                              bool is_of_one_recording) {
  std::vector<std::vector<std::size_t>> sets;
  ByRecording by_recording;
  for (std::size_t c = begin; c < end; ++c) {
    const auto& recording = screen.candidates()[c].effects.front().recording();
    if (!recording || is_of_one_recording)
      sets.push_back({c});
    else
      by_recording[*recording].push_back(c);
  }
  if (by_recording.empty()) return sets;
  const std::vector<std::size_t> together = likeliest_together(screen, by_recording);
  sets.push_back(together);
  // A step from zero says little of where a force that grows with the square of a speed comes from.
  std::size_t place = 0;
  for (const auto& [recording, candidates] : by_recording)
    if (auto opposite = with_opposite(screen, together, place++, candidates); !opposite.empty())
      sets.push_back(std::move(opposite));
  return sets;
}

EffectScreen screen_of(const Campaign& campaign, const Fitted& fitted, std::vector<Candidate> candidates,
                       const ScreenOptions& options) {
  return {campaign,
          fitted.fit,
          fitted.hypothesis,
          std::move(candidates),
          1.0,
          widths_by_scale(fitted.fit.stated, fitted.fit.parameters, fitted.fit.effects),
          options};
}

void sort(std::vector<Start>& starts) {
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.log_evidence > b.log_evidence; });
}

}  // namespace leeway::gap
