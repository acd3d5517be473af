#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gap/compare/fit_search.hpp"
#include "gap/compare/probabilities.hpp"
#include "gap/compare/tugs.hpp"
#include "gap/decide/decide.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

struct ComparisonOptions {
  double false_alarm = kPolicy.detect.false_alarm;
  std::size_t jobs = 1;
  std::uint64_t seed = 1;
  bool none_is_possible = true;  ///< that nothing is missing: then its fit has to be as good as the others'
};

/// Hypotheses about one campaign, all fitted to the same data. The first is that nothing is missing.
class Comparison {
 public:
  Comparison(const Campaign& campaign, const FittedNull& null, const ComparisonOptions& options);

  const Fitted& none() const { return all_.front(); }
  const std::vector<Fitted>& all() const { return all_; }
  const Blocks& blocks() const { return blocks_; }  ///< where each begins; their evidence is that of the null fit
  const std::vector<std::vector<std::size_t>>& folds() const { return folds_; }

  /// An effect, or a pair of them, of which one linear step from a fit expects a gain, and where fits with it may
  /// start.
  struct ExpectedGain {
    std::string effect;
    std::vector<Start> starts;  ///< the best first
    double gain = 0.0;          ///< of the evidence [nats]
  };
  /// What the effects of the catalogue are expected to gain beside those of `from`, the largest first. A screen about
  /// the fit without them would miss those that the parameters imitate, and so have left.
  ///   unexcited  takes the names of those that change nothing
  ///   pairs      takes all pairs of them, the one with the largest expected gain first
  std::vector<ExpectedGain> expected_gains(std::size_t from, std::vector<std::string>* unexcited = nullptr,
                                           std::vector<ExpectedGain>* pairs = nullptr);
  /// The same for the effects that are bound to a place, which is sought about the tracks: walls, anchors, and where
  /// something acts at times, walls that the hull touches.
  ///   events  when something acts
  std::vector<ExpectedGain> expected_gains_of_places(std::size_t from, const std::vector<Interval>& events);
  /// Starts of `from` with one effect more, also with one that differs between recordings where it can; none where the
  /// ship lacks what it needs.
  std::vector<Start> starts_with(std::size_t from, const std::string& effect, const FreeEffect::Choice& choice);

  /// Fits `from` with one effect more, and keeps the result; its place, or nothing where it cannot be fitted, or lets
  /// the rudders act no otherwise than their angles are known, or is no
  /// more than another effect (a sheared current without shear), or, beside others in recordings without noise, takes
  /// hardly any model error away: inputs between the samples make as much.
  ///   most_starts  from which it is fitted, the one of the largest expected gain first
  std::optional<std::size_t> add(std::size_t from, const std::vector<Start>& starts, std::size_t most_starts = 2);

  /// The same from coefficients as stated alone, where those of `from` have moved and the effect is nothing at no
  /// finite strength: one step from moved coefficients, which imitate what multiplies them, expects too little of it.
  /// Nothing elsewhere.
  std::optional<std::size_t> add_as_stated(std::size_t from, const std::vector<Start>& starts);
  /// By how much coefficients where a fit has them are less likely than as stated [nats]: what an effect that lets them
  /// stay there may save.
  double cost_of_shifts(std::size_t from) const;

  /// Continues a fit as long as it gains: it is what others are compared to.
  void refine(std::size_t i);
  /// Fits it once more from coefficients as wrong as stated: those that may be far off imitate what is missing, so that
  /// there may be an optimum with each.
  void refine_scale(std::size_t i);
  /// Fits nothing missing once more from the noise, events and coefficients of another fit: there may be
  /// several optima. Whether it found a better one: then all other hypotheses are forgotten.
  bool refit_none(std::size_t from);

  /// Sum over the folds of what `better` predicts better, and its standard error [nats].
  static std::pair<double, double> gain(const Fitted& better, const Fitted& than) {
    return heldout_gain(better.fold_evidence, than.fold_evidence);
  }
  double log_odds(std::size_t i) const { return gap::log_odds(all_, i); }
  /// How often one effect or another would have such odds beside those of `than` (0: none) where these are all that is
  /// missing, in campaigns drawn from the linear model about that fit; beyond them, where little was recorded, and
  /// where no effect could be drawn, in inverse proportion to the odds (Markov's inequality). 1 where nothing was
  /// screened beside it.
  double chance_of(std::size_t i, std::size_t than = 0) const;
  /// Whether that is rarer than the rate, in all families of tests.
  bool is_rare(std::size_t i, std::size_t than) const {
    return kPolicy.decide.families * chance_of(i, than) < options_.false_alarm;
  }
  std::vector<Unseen> unseen_effects() const { return gap::unseen_effects(all_, screened_, campaign_.ship); }
  std::vector<double> probabilities() const { return gap::probabilities(all_, unseen_effects()); }
  /// Whether it is stated as likelier than all others together.
  bool is_likelier_than_not(std::size_t i) const { return probabilities()[i] > kPolicy.compare.likelier_than_not; }
  /// Whether `better` is likelier than `than`, predicts what was left out better beyond chance, and each of its effects
  /// is more than nothing.
  ///   is_surely_left  whether something is left beside `than`: then one standard error is enough; where the
  ///                   evidence for a name is strong, none is needed
  bool holds(std::size_t better, std::size_t than, bool is_surely_left) const;
  /// Whether each of its effects is more than nothing, by its own standard deviation.
  bool is_significant(std::size_t i) const { return is_significant(all_[i]); }

 private:
  bool is_significant(const Fitted& fitted) const;
  bool is_below_known_angles(const Fitted& fitted) const;
  bool is_worth_a_name(const Fitted& with, const Fitted& without) const;
  bool is_another_effect(const Fitted& fitted) const;
  void judge(Fitted& fitted) const;

  const Campaign& campaign_;
  const ComparisonOptions options_;
  const FitSearch search_;
  Blocks blocks_;
  std::vector<Fitted> all_;
  std::vector<std::vector<std::size_t>> folds_;
  std::map<std::size_t, std::vector<ExpectedGain>> expected_;  ///< beside fits that have not gained since
  ScreenedGains screened_;
  std::map<std::size_t, std::vector<double>> gains_of_nothing_;  ///< of drawn campaigns, ascending, by what is fitted
};

}  // namespace leeway::gap
