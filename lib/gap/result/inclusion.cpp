#include "gap/result/inclusion.hpp"

#include <algorithm>
#include <functional>
#include <set>

namespace leeway::gap {

std::string coefficient_in_inclusion(const std::string& name) { return "coefficient:" + name; }

namespace {

// Of a hypothesis, alone or with one effect more.
double probability_with_more(const Explained& hypothesis) {
  double odds_of_more = 0.0;
  for (const auto& [effect, odds] : hypothesis.unseen) odds_of_more += odds;
  return hypothesis.probability * (1.0 + odds_of_more);
}

// Names of what has no fit of its own come on top of the hypotheses: by this all probabilities are divided.
double sum_of_all(const Explanation& explanation) {
  double sum = 0.0;
  for (const Explained& hypothesis : explanation.hypotheses) sum += probability_with_more(hypothesis);
  return std::max(sum, 1.0);
}

}  // namespace

std::map<std::string, double> inclusion(const Explanation& explanation) {
  std::map<std::string, double> result;
  for (const Explained& hypothesis : explanation.hypotheses) {
    const std::set<std::string> names(hypothesis.effects.begin(), hypothesis.effects.end());
    const double with_more = probability_with_more(hypothesis);
    for (const std::string& name : names) result[name] += with_more;
    for (const auto& [effect, odds] : hypothesis.unseen)
      if (!names.contains(effect)) result[effect] += hypothesis.probability * odds;
    for (const auto& [name, probability] : hypothesis.coefficients_off)
      result[coefficient_in_inclusion(name)] += with_more * probability;
  }
  const double all = sum_of_all(explanation);
  for (auto& [name, probability] : result) probability = std::min(probability / all, 1.0);
  return result;
}

double not_fitted(const Explanation& explanation) {
  double fitted = 0.0;
  for (const Explained& hypothesis : explanation.hypotheses) fitted += hypothesis.probability;
  return std::max(0.0, 1.0 - fitted / sum_of_all(explanation));
}

std::vector<ProbableSet> probable_sets(const Explanation& explanation) {
  struct Shared {
    std::vector<std::string> names;
    double probability = 0.0;
    bool is_fitted = false;
  };
  std::map<std::set<std::string>, Shared> sets;
  const auto add = [&](std::vector<std::string> names, double probability, bool is_fitted) {
    Shared& one = sets[{names.begin(), names.end()}];
    if (is_fitted || one.names.empty()) one.names = std::move(names);
    one.probability += probability;
    one.is_fitted |= is_fitted;
  };
  for (const Explained& hypothesis : explanation.hypotheses) {
    add(hypothesis.effects, hypothesis.probability, true);
    for (const auto& [effect, odds] : hypothesis.unseen) {
      std::vector<std::string> names = hypothesis.effects;
      if (std::ranges::find(names, effect) == names.end()) names.push_back(effect);
      add(std::move(names), hypothesis.probability * odds, false);
    }
  }
  std::vector<Shared> ordered;
  ordered.reserve(sets.size());
  for (auto& [key, one] : sets) ordered.push_back(std::move(one));
  std::ranges::stable_sort(ordered, std::greater(), &Shared::probability);
  std::vector<ProbableSet> result;
  const double all = sum_of_all(explanation);
  double held = 0.0;
  for (Shared& one : ordered) {
    const double probability = one.probability / all;
    const bool is_credible = held < kPolicy.show.credible;
    held += probability;
    if (is_credible || one.is_fitted) result.push_back({std::move(one.names), probability, is_credible});
  }
  return result;
}

}  // namespace leeway::gap
