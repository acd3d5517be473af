#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gap/result/findings.hpp"
#include "recording/trajectory.hpp"

/// Faults of sensors, judged and refined with the simulator's help.
namespace leeway::gap {

/// Gives faults the p-values of all families of tests.
void share_rate(Audit& audit);

/// A fault that noise feigns in one of some hundred campaigns.
bool is_faint(const Fault& fault, double false_alarm);
/// Sensors are late, not early; positions that are early stand for all others that are late.
bool is_early(const Fault& fault);
/// Whether its numbers can be free in the measurement function; those of a current move the ship.
bool can_be_compared(const Fault& fault);

/// Leaves the faults that are certain, and says why the others are not so.
void withdraw(Findings& findings, std::vector<Fault> certain, const std::string& why);

/// The likeliest numbers of faults, within two standard errors of the audit, since what is left of a bias looks like
/// missing physics, and what is missing like a bias. Each fault gives way to a likelier one of its rivals or, where a
/// channel is late, of all that are late; those that are about as likely are its rivals then,
/// and those that cannot be fitted go.
///   hypotheses  all that the audit tried
///   fit         ln p(recordings | faults), at their likeliest numbers, which they get; nothing where it cannot tell
void refine(std::vector<Fault>& faults, const std::vector<Fault>& hypotheses,
            const std::function<std::optional<double>(std::vector<Fault>&)>& fit);

}  // namespace leeway::gap
