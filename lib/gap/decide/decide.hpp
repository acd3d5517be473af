#pragma once

#include <cstddef>
#include <optional>

#include "gap/policy/policy.hpp"
#include "gap/result/verdict.hpp"

/// The one place where verdicts are made: a pure function of what the stages found. Reports state it.
namespace leeway::gap {

struct Found {
  double false_alarm = 0.01;  ///< the rate that the verdict keeps
  TestsFound tests;
  std::optional<HypothesesFound> hypotheses;  ///< of gap-explain
};

/// Why the tests lead to their verdict.
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
  errs_as_much,
  not_white,
  far_parameters,
  nothing_left,
};

struct Decision {
  Verdict verdict = Verdict::undecided;
  double p_value = 1.0;  ///< of all families of tests; with a name, at most what its odds let it be
  Reason reason = Reason::nothing_left;
  bool claims_names = false;    ///< whether the effects of the chosen hypothesis are claimed
  bool claims_unknown = false;  ///< whether `unknown` stands beside them, or alone
  bool is_complete = true;      ///< whether nothing significant is left beside what was chosen
};

/// The verdict of gap-locate; where hypotheses were compared, that of gap-explain.
Decision decide(const Found& found, const Policy& policy = kPolicy);

/// Whether parameters are so far off, and so much is left, that this may be another ship.
bool errs_grossly(std::size_t far_parameters, double error_share, const Policy& policy = kPolicy);

/// By which p-values of one test become those of all.
constexpr double tests(const Policy& policy = kPolicy) { return policy.decide.families * policy.decide.alarms_by_rate; }

/// p-value below which what has no name is called unknown: the square of the rate.
constexpr double surely(double false_alarm) { return false_alarm * false_alarm; }
/// The same beside what is named, whose form may be a little other than the catalogue's.
constexpr double surely_beside(double false_alarm) { return surely(false_alarm) * surely(false_alarm); }

/// How two hypotheses compare.
struct Rivals {
  double log_odds = 0.0;             ///< of the better one against the other [nats]
  bool is_significant = false;       ///< whether each effect of the better one is more than nothing
  bool has_terms = false;            ///< whether the better one has terms for what the catalogue does not hold
  bool against_nothing = false;      ///< whether the other one is that nothing is missing
  double gain = 0.0, gain_sd = 0.0;  ///< on what was left out [nats]
  double p_value = 1.0;              ///< of something being left beside the other one
};
/// Whether the better one is likelier, predicts what was left out better beyond chance, and has no needless effect:
/// where p is tiny or the odds are strong, one standard error is enough; where the odds for a name are strong, none.
bool holds(const Rivals& rivals, double false_alarm, const Policy& policy = kPolicy);

}  // namespace leeway::gap
