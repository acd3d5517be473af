#pragma once

#include "gap/policy/policy.hpp"

/// Which faults of sensors and which readings of channels are claimed: pure functions of what their tests found.
namespace leeway::gap {

/// A fault against the recordings without it.
struct FaultTest {
  double p_value = 1.0;                              ///< family-wise
  double heldout_gain = 0.0, heldout_gain_sd = 0.0;  ///< [nats], sum over what was left out, and its standard error
};
/// Whether it predicts what was left out better beyond chance; where p is certain, one standard error is enough.
bool predicts_better(const FaultTest& test, double false_alarm, const Policy& policy = kPolicy);
/// The same, and the p-value is below the rate.
bool is_found(const FaultTest& test, double false_alarm, const Policy& policy = kPolicy);
/// Whether a fault that was found asks for the simulator's word: its p-value, once families share the rate, is not
/// below the square of it.
bool is_faint(double p_value, double false_alarm, const Policy& policy = kPolicy);
/// What the filter says of a fault against sound sensors, and of the best effect or latent force in its place.
struct FaultOdds {
  double log_bayes_factor = 0.0;  ///< of the fault, averaged over how large faults are [nats]
  double of_best_force = 0.0;  ///< ln of the evidence with the best of these and sound sensors, by that without [nats]
  double chance = 1.0;         ///< how often any fault has so much where nothing is wrong
  double heldout_gain = 0.0, heldout_gain_sd = 0.0;  ///< as in FaultTest
};
/// Whether a fault is claimed by these odds: they are rarer than the rate where nothing is wrong, it predicts better
/// what was left out, and is likelier than the best force in its place.
bool is_identified(const FaultOdds& odds, double false_alarm, const Policy& policy = kPolicy);

/// One way to read a channel against another.
struct ReadingTest {
  double log_odds = 0.0, ratio = 1.0;  ///< ratio: of the errors
  bool is_certain = false;             ///< the blocks agree
};
/// Whether it is claimed where kinematics judge, which know no parameters.
bool holds_by_kinematics(const ReadingTest& test, const Policy& policy = kPolicy);
/// The same where the ship's forces do.
bool holds_by_forces(const ReadingTest& test, const Policy& policy = kPolicy);
/// Whether it also beats a plain error of the force.
///   gain  of the force that stands for that error; 0: there is no force at all
bool beats_plain_error(const ReadingTest& test, double gain, const Policy& policy = kPolicy);

}  // namespace leeway::gap
