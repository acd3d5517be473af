#include "gap/decide/decide.hpp"

#include <algorithm>
#include <cmath>

namespace leeway::gap {
namespace {

// Whether inputs that are known at the samples alone are the larger error, so that what the tests see may be that.
bool is_of_inputs(const TestsFound& tests, const Policy& policy) {
  return tests.is_noise_free && tests.error_share < policy.decide.error_of_inputs;
}

// The verdict of the tests; the first that applies.
Decision decide_tests(const Found& found, const Policy& policy) {
  const TestsFound& t = found.tests;
  const DecidePolicy& limits = policy.decide;
  const double rate = found.false_alarm,
               p = std::min(1.0, policy.decide.families * std::min(t.effects_p, t.intervals_p));
  const bool improves = t.heldout_gain > limits.heldout_sd * t.heldout_gain_sd ||
                        (t.heldout_gain > limits.heldout_sd_if_certain * t.heldout_gain_sd && p < surely(rate));
  const auto because = [&](Verdict verdict, Reason reason) { return Decision{verdict, p, reason}; };

  if (!t.converged) return because(Verdict::undecided, Reason::not_converged);
  if (p < limits.nearly * rate && is_of_inputs(t, policy)) return because(Verdict::undecided, Reason::error_of_inputs);
  if (p < rate && t.intervals_p < t.effects_p) return because(Verdict::mismatch, Reason::interval);
  if (p < rate && improves) return because(Verdict::mismatch, Reason::effect);
  if (p < rate) return because(Verdict::undecided, Reason::effect_not_heldout);
  if (!found.hypotheses && p < limits.nearly * rate) return because(Verdict::undecided, Reason::close_to_rate);
  if (t.small_intervals > 0) return because(Verdict::undecided, Reason::small_intervals);
  if (t.untrained_intervals > 0) return because(Verdict::undecided, Reason::untrained_intervals);
  if (t.samples < limits.fewest_samples) return because(Verdict::undecided, Reason::too_few_samples);
  if (t.effects_tested == 0) return because(Verdict::undecided, Reason::nothing_excited);
  if (!found.hypotheses && errs_grossly(t.far_parameters, t.error_share, policy))
    return because(Verdict::undecided, Reason::far_parameters);
  return because(Verdict::no_mismatch, Reason::nothing_left);
}

// What is claimed beside that, where hypotheses were compared.
void decide_hypotheses(const HypothesesFound& h, double intervals_p, double rate, const Policy& policy,
                       Decision& decision) {
  const DecidePolicy& limits = policy.decide;
  const bool errs = h.error_share >= limits.error_of_forms;
  const double tests_p = decision.p_value;
  Verdict& verdict = decision.verdict;
  const auto leave_open = [&](Reason reason) {
    verdict = Verdict::undecided;
    decision.reason = reason;
  };
  if (!h.is_named && h.is_latent) {
    verdict = Verdict::mismatch;
    decision.p_value = std::min(tests_p, policy.decide.families * h.chance_of_latent);
    decision.claims_unknown = true;
    decision.is_complete = false;
    return;
  }
  if (h.is_named) {
    verdict = Verdict::mismatch;
    decision.p_value = std::min(tests_p, policy.decide.families * h.chance_of_best);
  }
  // Without a name what the tests for effects see is neither claimed nor denied: names have odds. So is what intervals
  // barely show, or what is too little to be called unknown.
  if (verdict == Verdict::mismatch && !h.is_named && (!errs || intervals_p >= surely(rate)))
    leave_open(Reason::odds_not_rare);
  // Likelier than not, but not shown: neither claimed nor denied.
  if (verdict == Verdict::no_mismatch) {
    decision.p_value = std::min(tests_p, policy.decide.families * std::min(h.chance_of_best, h.chance_of_latent));
    if (h.is_likelier_than_not)
      leave_open(!h.best_is_likelier_than_not || limits.families * h.chance_of_best >= rate ? Reason::likelier_than_not
                 : h.best_is_significant ? Reason::likelier_but_not_heldout
                                         : Reason::likelier_but_not_told_from_none);
  }
  if (verdict != Verdict::mismatch) return;

  if (h.is_named && h.is_latent) {
    decision.claims_names = decision.claims_unknown = true;
    decision.is_complete = false;
    return;
  }
  decision.is_complete = h.is_named && (h.left_p >= rate || h.is_negligible);
  decision.claims_names = h.is_named && (decision.is_complete || !errs || h.taken_share > limits.unexplained ||
                                         h.log_odds_of_chosen > limits.strong_odds);
  if (!decision.claims_names && h.left_p >= surely(rate)) {
    leave_open(Reason::odds_not_rare);
    return;
  }
  decision.claims_unknown = !decision.is_complete && errs && !(decision.claims_names && h.has_terms) &&
                            (!decision.claims_names || h.left_p < surely_beside(rate));
}

}  // namespace

Decision decide(const Found& found, const Policy& policy) {
  Decision decision = decide_tests(found, policy);
  if (found.hypotheses)
    decide_hypotheses(*found.hypotheses, std::min(1.0, policy.decide.families * found.tests.intervals_p),
                      found.false_alarm, policy, decision);
  if (found.sensors.count > 0) {
    decision.verdict = Verdict::mismatch;
    decision.claims_sensors = true;
    decision.p_value = std::min(decision.p_value, found.sensors.p_value);
  }
  return decision;
}

bool errs_grossly(std::size_t far_parameters, double error_share, const Policy& policy) {
  const DecidePolicy& limits = policy.decide;
  return far_parameters >= limits.far_parameters ||
         (far_parameters >= limits.far_parameters_with_error && error_share > limits.gross_error);
}

bool holds(const Rivals& r, const Policy& policy) {
  const DecidePolicy& limits = policy.decide;
  const ComparePolicy& of = policy.compare;
  if (!(r.log_odds > 0.0) || !r.is_significant) return false;
  // What a coefficient could do as well, if it were far off what is stated, predicts no better: it is likelier alone.
  // Terms are likelier wherever forms of forces differ.
  const bool has_strong_names = r.log_odds > of.strong_odds_beside && !r.has_terms;
  if (r.is_likelier_than_not && !r.has_terms && r.gain > -r.log_odds) return true;
  if (r.is_rare && !r.has_terms) return r.gain > -limits.heldout_sd * r.gain_sd;
  const double least = has_strong_names                                         ? 0.0
                       : r.is_surely_left || r.log_odds > of.strong_odds_beside ? limits.heldout_sd_if_certain
                                                                                : limits.heldout_sd;
  return r.gain > 0.0 && r.gain > least * r.gain_sd;
}

bool may_be_claimed(const Contender& c, double false_alarm, const Policy& policy) {
  return !c.has_terms || (c.error_share >= policy.decide.error_of_forms &&
                          (c.p_value < surely(false_alarm) || c.log_odds > policy.compare.strong_terms));
}

bool is_certain(const Likeliest& best, double false_alarm) {
  return best.chance < false_alarm && !(best.of_other_forms > best.probability);
}

bool is_rare(const LatentFound& latent, double false_alarm, const Policy& policy) {
  const double rate = latent.error_share < policy.decide.error_of_forms ? surely_beside(false_alarm) : false_alarm;
  return policy.decide.families * std::exp(-latent.log_evidence) < rate && !is_of_inputs(latent.tests, policy);
}

bool is_claimed(const LatentFound& latent, double false_alarm, const Policy& policy) {
  return is_rare(latent, false_alarm, policy) && latent.log_odds > std::max(0.0, latent.log_odds_of_names);
}

bool holds_beside(const LatentFound& latent, double false_alarm, const Policy& policy) {
  return policy.decide.families * std::exp(latent.log_odds - latent.log_odds_with_chosen) < false_alarm;
}

bool is_negligible(const LeftBeside& left, double false_alarm, const Policy& policy) {
  const ComparePolicy& limits = policy.compare;
  const bool is_little = -std::log(std::max(left.p_value, limits.least_p)) < limits.negligible_share * left.evidence;
  const bool is_only_likelier = left.log_odds_of_next && *left.log_odds_of_next > 0.0;
  return is_little || (left.p_value >= surely(false_alarm) && is_only_likelier);
}

bool may_have_terms(const LeftBeside& left, bool is_negligible, double false_alarm, const Policy& policy) {
  return left.p_value < surely_beside(false_alarm) && !is_negligible &&
         left.error_share >= policy.decide.error_of_forms;
}

}  // namespace leeway::gap
