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

std::vector<Unseen> unseen_effects(const std::vector<Fitted>& all, const ScreenedGains& screened_gains,
                                   const Ship& ship) {
  const auto unseen_beside = [&](std::size_t from) {
    Unseen result;
    for (const auto& [effect, gain] : screened_gains.at(from)) {
      Hypothesis more = all[from].hypothesis;
      more.effects.emplace_back(effect, ship);
      if (std::any_of(all.begin(), all.end(),
                      [&](const Fitted& fitted) { return name_set(fitted.hypothesis) == name_set(more); }))
        continue;
      // One linear step exaggerates: an expected gain alone makes nothing likelier than without it.
      result[effect] = std::exp(std::min(gain, 0.0) + log_prior(more) - log_prior(all[from].hypothesis));
    }
    return result;
  };
  std::optional<std::size_t> likeliest;
  for (const auto& [i, gains] : screened_gains)
    if (i != 0 && (!likeliest || log_odds(all, i) > log_odds(all, *likeliest))) likeliest = i;
  std::vector<Unseen> result(all.size());
  const Unseen of_likeliest = likeliest ? unseen_beside(*likeliest) : Unseen();
  for (std::size_t i = 0; i < all.size(); ++i)
    result[i] = i == likeliest || !screened_gains.contains(i) ? of_likeliest : unseen_beside(i);
  return result;
}

double sum_of(const Unseen& unseen) {
  double sum = 0.0;
  for (const auto& [effect, odds] : unseen) sum += odds;
  return sum;
}

std::vector<double> probabilities(const std::vector<Fitted>& all, const std::vector<Unseen>& unseen) {
  std::vector<double> odds(all.size());
  for (std::size_t i = 1; i < all.size(); ++i) odds[i] = log_odds(all, i);
  const double most = *std::max_element(odds.begin(), odds.end());
  double total = 0.0;
  for (std::size_t i = 0; i < odds.size(); ++i) {
    odds[i] = std::exp(odds[i] - most);
    total += odds[i] * (1.0 + sum_of(unseen[i]));
  }
  for (double& one : odds) one /= total;
  return odds;
}

}  // namespace leeway::gap
