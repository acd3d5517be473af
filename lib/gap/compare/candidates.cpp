#include "gap/compare/candidates.hpp"

#include <algorithm>
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

EffectScreen screen_of(const Campaign& campaign, const Fitted& fitted, std::vector<Candidate> candidates,
                       const ScreenOptions& options) {
  return {campaign,
          fitted.fit,
          fitted.hypothesis,
          std::move(candidates),
          1.0,
          widths_by_scale(fitted.fit.parameters, fitted.fit.effects),
          options};
}

void sort(std::vector<Start>& starts) {
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.log_evidence > b.log_evidence; });
}

}  // namespace leeway::gap
