#include "gap/compare/probabilities.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "effects/description.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// ln of what is believed before: none 1/5, one effect 2/5, two 1/5, three 1/10, ...; all sets of a size alike, and all
// sets of terms, all intervals.
double log_prior_of_number(std::size_t effects) {
  double result = -std::log(kPolicy.compare.sets_of_effects) - log_ways(count_of_tried_effects(), effects);
  if (effects > 0) result -= (static_cast<double>(effects) - 2.0) * std::log(kPolicy.compare.fewer_are_likelier);
  return result;
}

}  // namespace

// ln of the number of sets of `count` things out of `of`.
double log_ways(std::size_t of, std::size_t count) {
  double result = 0.0;
  for (std::size_t i = 0; i < count; ++i) result += std::log(static_cast<double>(of - i) / static_cast<double>(i + 1));
  return result;
}

double log_prior(const Hypothesis& hypothesis) {
  double result = log_prior_of_number(hypothesis.names().size());
  for (const FreeEffect& effect : hypothesis.effects) {
    result -= effect.log_ways();
    if (const EffectDescription& description = effect_named(effect.name());
        description.info.search == SearchStart::terms)
      result -= log_ways(description.parameters.size(), static_cast<std::size_t>(effect.size()));
  }
  return result;
}

double log_prior_odds_of_one(std::size_t beside) {
  return log_prior_of_number(beside + 1) - log_prior_of_number(beside);
}

double log_odds(const std::vector<Fitted>& all, std::size_t i) {
  return all[i].log_evidence - all.front().log_evidence + log_prior(all[i].hypothesis) - log_prior({});
}

double log_evidence_of(const std::vector<LatentForce>& kinds) {
  if (kinds.empty()) return -std::numeric_limits<double>::infinity();
  const double most = kinds.front().log_evidence;
  double sum = 0.0;
  for (const LatentForce& kind : kinds) sum += std::exp(kind.log_evidence - most);
  return most + std::log(sum / static_cast<double>(kinds.size()));
}

double log_odds_of(const std::vector<LatentForce>& kinds, std::size_t beside) {
  return log_evidence_of(kinds) + log_prior_odds_of_one(beside);
}

double least_odds_of_nothing(double p_value) {
  const double p = std::clamp(p_value, kPolicy.compare.least_p, std::exp(-1.0));
  return -std::exp(1.0) * p * std::log(p);
}

std::vector<double> probabilities(const std::vector<Fitted>& all, const ScreenedGains& screened_gains,
                                  const Ship& ship) {
  // Effects of which too little was expected to be fitted beside a hypothesis share in it as well.
  const auto unseen_beside = [&](std::size_t from) {
    double share = 0.0;
    for (const auto& [effect, gain] : screened_gains.at(from)) {
      Hypothesis more = all[from].hypothesis;
      more.effects.emplace_back(effect, ship);
      if (std::any_of(all.begin(), all.end(),
                      [&](const Fitted& fitted) { return name_set(fitted.hypothesis) == name_set(more); }))
        continue;
      // One linear step exaggerates: an expected gain alone makes nothing likelier than without it.
      share += std::exp(std::min(gain, 0.0) + log_prior(more) - log_prior(all[from].hypothesis));
    }
    return share;
  };
  std::vector<double> odds(all.size());
  for (std::size_t i = 1; i < all.size(); ++i) odds[i] = log_odds(all, i);
  const double most = *std::max_element(odds.begin(), odds.end());
  for (double& one : odds) one = std::exp(one - most);
  // What was not screened is as likely to lack another effect that does not show as the likeliest that was.
  std::map<std::size_t, double> unseen;
  std::optional<std::size_t> likeliest;
  for (const auto& [i, gains] : screened_gains) {
    unseen[i] = unseen_beside(i);
    if (i != 0 && (!likeliest || odds[i] > odds[*likeliest])) likeliest = i;
  }
  double total = 0.0;
  for (std::size_t i = 0; i < odds.size(); ++i) {
    const auto own = unseen.find(i);
    total += odds[i] * (1.0 + (own != unseen.end() ? own->second : likeliest ? unseen[*likeliest] : 0.0));
  }
  for (double& one : odds) one /= total;
  return odds;
}

}  // namespace leeway::gap
