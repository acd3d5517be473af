#include "gap/decide/sensors.hpp"

#include <algorithm>
#include <cmath>

#include "gap/decide/decide.hpp"

namespace leeway::gap {

bool predicts_better(const FaultTest& test, double false_alarm, const Policy& policy) {
  const SensorsPolicy& limits = policy.sensors;
  const double least = test.p_value < limits.certain_p * false_alarm ? limits.heldout_sd_if_certain : limits.heldout_sd;
  return test.heldout_gain > 0.0 && test.heldout_gain > least * test.heldout_gain_sd;
}

bool is_found(const FaultTest& test, double false_alarm, const Policy& policy) {
  return test.p_value < false_alarm && predicts_better(test, false_alarm, policy);
}

bool is_faint(double p_value, double false_alarm, const Policy& policy) {
  return p_value >= policy.decide.families * surely(false_alarm);
}

bool is_identified(const FaultOdds& odds, double false_alarm, const Policy& policy) {
  return odds.chance < false_alarm && odds.log_bayes_factor > odds.of_best_force + policy.decide.contradicted &&
         predicts_better({odds.chance, odds.heldout_gain, odds.heldout_gain_sd}, false_alarm, policy);
}

bool holds_by_kinematics(const ReadingTest& test, const Policy& policy) {
  return test.log_odds >= policy.sensors.decisive_odds && test.ratio >= policy.sensors.kinematic_ratio &&
         test.is_certain;
}

bool holds_by_forces(const ReadingTest& test, const Policy& policy) {
  return test.log_odds > policy.sensors.decisive_odds && test.is_certain && test.ratio > policy.sensors.force_ratio;
}

bool beats_plain_error(const ReadingTest& test, double gain, const Policy& policy) {
  return test.log_odds > policy.sensors.odds_against_plain && test.is_certain &&
         test.ratio > (gain == 0.0 ? policy.sensors.absent_ratio : policy.sensors.force_ratio);
}

}  // namespace leeway::gap
