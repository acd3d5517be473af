#pragma once

#include <map>
#include <string>

#include "gap/detect.hpp"
#include "gap/screen.hpp"

namespace leeway::gap {

inline constexpr double kStrong = 5.7;  ///< nats of posterior odds: then the p-value is not asked

/// A hypothesis with its fit.
struct Fitted {
  Hypothesis hypothesis;
  FittedNull fit;
  /// Of the coefficients, between what is stated (0) and what is tolerated (1): what makes the recordings likeliest.
  /// Where all coefficients but one agree with what is stated, that one is no wrong coefficient.
  double tolerance = 1.0;
  double log_evidence = 0.0;          ///< absolute [nats]
  std::vector<double> fold_evidence;  ///< ln p(what was left out | the rest), by fold
  double kappa = 1.0;                 ///< by which correlation between blocks widens variances
  double gain = 0.0, gain_sd = 0.0;   ///< over nothing missing, on what was left out [nats]
};

struct ComparisonOptions {
  double false_alarm = 0.01;
  std::size_t jobs = 1;
  bool none_is_possible = true;  ///< that nothing is missing: then its fit has to be as good as the others'
};

/// Hypotheses about one campaign, all fitted to the same data. The first is that nothing is missing.
class Comparison {
 public:
  Comparison(Campaign& campaign, const FittedNull& null, const ComparisonOptions& options);

  const Fitted& none() const { return all_.front(); }
  const std::vector<Fitted>& all() const { return all_; }
  const Blocks& blocks() const { return blocks_; }  ///< where each begins; their evidence is that of the null fit
  const std::vector<std::vector<std::size_t>>& folds() const { return folds_; }

  /// An effect that one linear step from a fit promises something of, and where fits with it may start.
  struct Promise {
    std::string effect;
    std::vector<Start> starts;  ///< most promising first
    double gain = 0.0;          ///< of the evidence [nats]
  };
  /// What the effects of the catalogue promise beside those of `from`, the most promising first. A screen about the fit
  /// without them would miss those that the parameters imitate, and so have left.
  ///   unexcited  takes the names of those that change nothing
  ///   pair       takes the start of the most promising pair of them
  std::vector<Promise> promises(std::size_t from, std::vector<std::string>* unexcited = nullptr,
                                std::vector<Start>* pair = nullptr);
  /// The same for the effects that are bound to a place, which is sought about the tracks: bank, mooring, and where
  /// something acts at times, fender.
  ///   events  when something acts
  std::vector<Promise> promises_of_places(std::size_t from, const std::vector<Interval>& events);
  /// The few terms of the effect `unknown`, at most three, that best explain what is left beside `from`, by one linear
  /// step: all sets among the most telling are compared. None where no set is worth its own number of ways.
  std::vector<Start> terms_beside(std::size_t from);
  /// Starts of `from` with one effect more, also with one that differs between recordings where it can; none where the
  /// ship lacks what it needs.
  std::vector<Start> starts_with(std::size_t from, const std::string& effect, const FreeEffect::Choice& choice);

  /// The same with a tug of unknown force, direction and point of action in each of some intervals of different
  /// recordings, whose ends are moved to where it explains most.
  std::vector<Start> starts_with_tugs(std::size_t from, const std::vector<Interval>& intervals) const;

  /// Fits `from` with one effect more, and keeps the result; its place, or nothing where it cannot be fitted, or lets
  /// the rudders act no otherwise than they may have between samples, or than their angles are known, or is no
  /// more than another effect (a sheared current without shear), or, beside others, takes hardly any model error away:
  /// inputs between the samples make as much.
  ///   most_starts  from which it is fitted, the most promising first
  std::optional<std::size_t> add(std::size_t from, const std::vector<Start>& starts, std::size_t most_starts = 2);

  /// Goes on with a fit as long as it gains: it is what others are compared to.
  void settle(std::size_t i);
  /// Fits nothing missing once more from the noise, events and coefficients of another fit: there are several places to
  /// rest. Whether it found a better one: then all other hypotheses are forgotten. Not tried of long campaigns, to save
  /// time.
  bool settle_none(std::size_t from);

  /// Sum over the folds of what `better` predicts better, and its standard error [nats].
  std::pair<double, double> gain(const Fitted& better, const Fitted& than) const;
  /// ln of the posterior odds against nothing missing. Correlation between blocks takes from all evidence what it takes
  /// from that of the likeliest.
  double log_odds(std::size_t i) const;
  /// Of all that were fitted; between those that lack something tempered. What is missing to 1 is shared by the single
  /// effects that were screened alone.
  std::vector<double> probabilities() const;
  /// Whether `better` is likelier than `than`, predicts what was left out better beyond chance, and each of its effects
  /// is more than nothing.
  ///   p_value  of something being left beside `than`: where it is tiny, one standard error is enough; where
  ///            the evidence for a name is strong, none is needed
  bool holds(std::size_t better, std::size_t than, double p_value) const;

 private:
  bool is_significant(const Fitted& fitted) const;
  bool is_between_samples(const Fitted& fitted) const;
  bool is_worth_a_name(const Fitted& with, const Fitted& without) const;
  bool is_another_effect(const Fitted& fitted) const;
  void settle_tolerance(Fitted& fitted);
  bool go_on(Fitted& fitted, bool anew = true);  // whether it gained
  void judge(Fitted& fitted) const;
  Candidate tug_in(std::size_t from, const Interval& interval) const;
  void mend_tugs(Fitted& fitted);
  EffectScreen screen_of(std::size_t from, std::vector<Candidate> candidates, const ScreenOptions& options) const;
  std::vector<Candidate> candidates_with(const std::string& effect, const FreeEffect::Choice& choice) const;

  Campaign& campaign_;
  const ComparisonOptions options_;
  FitOptions fit_options_;
  Blocks blocks_;
  std::vector<Fitted> all_;
  std::vector<std::vector<std::size_t>> folds_;
  std::map<std::size_t, std::map<std::string, double>> screened_;  ///< what each promised beside a fit [nats]
};

/// The evidence of all blocks but those of a fold.
Evidence without(const Evidence& total, const Blocks& blocks, const std::vector<std::size_t>& fold);
/// The best theta near a fit's for other evidence.
Eigen::VectorXd refitted(const FittedNull& fit, const Evidence& evidence);

/// Runs of the coordinates of a hypothesis that belong to one effect, which may differ between recordings.
struct EffectSpan {
  std::size_t effect = 0, effects = 1;  ///< first, and how many, of Hypothesis::effects
  Eigen::Index first = 0, count = 0;    ///< coordinates
};
std::vector<EffectSpan> spans_of(const Hypothesis& hypothesis);

}  // namespace leeway::gap
