#pragma once

#include <cstddef>
#include <optional>

#include "gap/policy/policy.hpp"
#include "gap/result/verdict.hpp"

/// The one place where verdicts are made: a pure function of what the stages found. Reports state it.
namespace leeway::gap {

/// Faults of sensors, and conventions that recordings contradict.
struct SensorsFound {
  std::size_t count = 0;
  double p_value = 1.0;  ///< the smallest of them, once families share the rate; 0 of a convention
};

struct Found {
  double false_alarm = kPolicy.detect.false_alarm;  ///< the rate that the verdict keeps
  TestsFound tests;
  std::optional<HypothesesFound> hypotheses;  ///< of gap-explain
  SensorsFound sensors;                       ///< likewise: gap-locate's verdict is of the forces alone
};

/// Why the tests, or the hypotheses, lead to their verdict.
enum class Reason {
  not_converged,
  error_of_inputs,
  interval,
  effect,
  effect_not_heldout,
  close_to_rate,
  small_intervals,
  untrained_intervals,
  too_few_samples,
  nothing_excited,
  far_parameters,
  nothing_left,
  odds_not_rare,      ///< the tests see something, and no hypothesis has odds that are rare where nothing is missing
  likelier_than_not,  ///< the tests see nothing
  likelier_but_not_told_from_none,  ///< with odds that are rare where nothing is missing, but an effect may be none
  likelier_but_not_heldout,         ///< with such odds, but it does not predict better what was left out
};

struct Decision {
  Verdict verdict = Verdict::undecided;
  double p_value = 1.0;  ///< of all families of tests; with a name, at most what its odds let it be
  Reason reason = Reason::nothing_left;
  bool claims_sensors = false;  ///< whether faults of sensors and contradicted conventions are
  bool claims_names = false;    ///< whether the effects of the chosen hypothesis are claimed
  bool claims_unknown = false;  ///< whether `unknown` stands beside them, or alone
  bool is_complete = true;      ///< whether nothing significant is left beside what was chosen
};

/// The verdict of gap-locate; where hypotheses were compared, that of gap-explain. With a fault of a sensor something
/// is wrong, whatever is found of the forces.
Decision decide(const Found& found, const Policy& policy = kPolicy);

/// Whether parameters are so far off, and so much is left, that this may be another ship.
bool errs_grossly(std::size_t far_parameters, double error_share, const Policy& policy = kPolicy);

/// p-value below which what has no name is called unknown: the square of the rate.
constexpr double surely(double false_alarm) { return false_alarm * false_alarm; }
/// The same beside what is named, whose form may be a little other than the catalogue's.
constexpr double surely_beside(double false_alarm) { return surely(false_alarm) * surely(false_alarm); }

/// How two hypotheses compare.
struct Rivals {
  double log_odds = 0.0;        ///< of the better one against the other [nats]
  bool is_significant = false;  ///< whether each effect of the better one is more than nothing
  bool has_terms = false;       ///< whether the better one has terms for what the catalogue does not hold
  /// Whether such odds are rarer than the rate where the other one holds all that is missing.
  bool is_rare = false;
  double gain = 0.0, gain_sd = 0.0;  ///< on what was left out [nats]
  bool is_surely_left = false;       ///< whether something surely is left beside the other one
  /// Whether the better one is stated as likelier than all others together; false against nothing missing.
  bool is_likelier_than_not = false;
};
/// Whether the better one is likelier, predicts what was left out better beyond chance, and has no needless effect:
/// where something surely is left or the odds are strong, one standard error is enough; where a name is the only one in
/// question and its odds are rare or strong, none. What is likelier than not may lose there what its odds gain.
bool holds(const Rivals& rivals, const Policy& policy = kPolicy);

/// One of the hypotheses when the likeliest is taken.
struct Contender {
  bool has_terms = false;    ///< for what the catalogue does not hold
  double log_odds = 0.0;     ///< against nothing missing [nats]
  double error_share = 0.0;  ///< model error by the typical acceleration, where nothing is missing
  double p_value = 1.0;      ///< of the tests for effects
};
/// Whether it may be claimed: terms are always likelier than nothing where the forms of the forces are not quite those
/// of the ship.
bool may_be_claimed(const Contender& contender, double false_alarm, const Policy& policy = kPolicy);

/// The likeliest that may be claimed, and what it is compared with.
struct Likeliest {
  double probability = 0.0;     ///< as stated
  double of_other_forms = 0.0;  ///< the largest of those that may not be claimed; 0: there are none
  double chance = 1.0;          ///< of such odds where nothing is missing, for all families of tests
};
/// Whether it is claimed if it holds against nothing: its odds are rare, and no forms of forces that may not be claimed
/// are likelier, since then an effect imitates them.
bool is_certain(const Likeliest& best, double false_alarm);

/// What the catalogue does not hold, but is known by what it depends on.
struct LatentFound {
  double log_evidence = 0.0;       ///< ln of how many times likelier it makes the recordings than nothing missing does
  double log_odds = 0.0;           ///< the same with prior odds
  double log_odds_of_names = 0.0;  ///< of all fitted hypotheses of the catalogue together
  double error_share = 0.0;        ///< model error by typical acceleration, where it is largest
  TestsFound tests;
  double log_odds_with_chosen = 0.0;  ///< of the chosen names with what acts beside them
};
/// Whether such evidence is rarer than the rate where nothing is missing, by Markov's inequality: its mean is 1 there.
/// Other forms of the ship's own forces are not in it: where the simulator errs by no more than they leave it has to be
/// surer. Never where inputs that are known at the samples alone are the larger error.
bool is_rare(const LatentFound& latent, double false_alarm, const Policy& policy = kPolicy);
/// Whether it is likelier than nothing missing, and than all names, besides.
bool is_claimed(const LatentFound& latent, double false_alarm, const Policy& policy = kPolicy);
/// Whether the chosen names are claimed beside it: such odds over it alone are rarer than the rate.
bool holds_beside(const LatentFound& latent, double false_alarm, const Policy& policy = kPolicy);

/// What is left beside what is named.
struct LeftBeside {
  double p_value = 1.0;
  double evidence = 0.0;                   ///< of what is named, against nothing missing [nats]
  double error_share = 0.0;                ///< model error beside it, by the typical acceleration
  std::optional<double> log_odds_of_next;  ///< of the likeliest with one effect more, against it [nats]
};
/// Whether that is not worth a word: little beside what is named; or likelier with one effect more that is not shown to
/// help, which is not claimed, and is no unknown either.
bool is_negligible(const LeftBeside& left, double false_alarm, const Policy& policy = kPolicy);
/// Whether what is left is asked for in terms of what the catalogue does not hold.
bool may_have_terms(const LeftBeside& left, bool is_negligible, double false_alarm, const Policy& policy = kPolicy);

}  // namespace leeway::gap
