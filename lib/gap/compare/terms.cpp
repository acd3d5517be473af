#include "gap/compare/terms.hpp"

#include <algorithm>

#include "gap/compare/candidates.hpp"
#include "gap/compare/probabilities.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

std::string name_of_terms() { return effects_searched_from(SearchStart::terms).front(); }

bool has_terms(const std::vector<std::string>& names) {
  return std::any_of(names.begin(), names.end(),
                     [](const std::string& name) { return search_start(name) == SearchStart::terms; });
}

std::vector<Start> terms_beside(const Campaign& campaign, const Fitted& fitted, std::size_t jobs) {
  const std::string unknown = name_of_terms();
  const std::span<const EffectParameter> all_terms = effect_named(unknown).parameters;
  const auto only = [&](const std::vector<std::size_t>& terms) {
    FreeEffect::Choice choice;
    for (std::size_t i = 0; i < all_terms.size(); ++i)
      if (std::find(terms.begin(), terms.end(), i) == terms.end()) choice.fixed[std::string(all_terms[i].name)] = 0.0;
    return FreeEffect(unknown, campaign.ship, choice);
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < all_terms.size(); ++i) candidates.push_back({{only({i})}, Eigen::VectorXd::Zero(1)});
  const EffectScreen screen = screen_of(campaign, fitted, std::move(candidates), {jobs});

  // With what the choice among all sets of a size costs.
  const auto worth = [&](const std::vector<std::size_t>& terms) {
    return screen.log_evidence(terms) - log_ways(all_terms.size(), terms.size());
  };
  std::vector<std::pair<double, std::size_t>> singles;
  for (std::size_t i = 0; i < all_terms.size(); ++i) singles.emplace_back(-worth({i}), i);
  std::sort(singles.begin(), singles.end());
  const std::size_t n = std::min(kPolicy.compare.leading_terms, singles.size());
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
  start.hypothesis = fitted.hypothesis;
  start.hypothesis.effects.push_back(only(best));
  return {start};
}

std::optional<double> gain_of_terms(const std::vector<Fitted>& fits, const std::set<std::string>& beside) {
  std::set<std::string> with = beside;
  with.insert(name_of_terms());
  std::optional<double> of_both, alone;
  for (const Fitted& fit : fits) {
    const std::set<std::string> names = name_set(fit.hypothesis);
    const double value = fit.log_evidence + log_prior(fit.hypothesis);
    if (names == with) of_both = value;
    if (names == beside) alone = value;
  }
  if (!of_both || !alone) return std::nullopt;
  return *of_both - *alone - log_prior_odds_of_one(beside.size());
}

}  // namespace leeway::gap
