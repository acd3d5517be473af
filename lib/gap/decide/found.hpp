#pragma once

#include <string>
#include <vector>

#include "gap/decide/decide.hpp"
#include "gap/result/findings.hpp"

namespace leeway::gap {

/// Parameters of a fit that lie beyond far_parameter_sd of what is stated.
std::size_t far_parameters(const NullFit& fit, const Policy& policy = kPolicy);
/// Model error by typical acceleration, on the worst axis.
double error_share(const NullFit& fit);
/// Whether parameters are so far off, and so much is left, that this may be another ship.
bool errs_grossly(const NullFit& fit, const Policy& policy = kPolicy);

/// What is claimed of sensors: "convention" and the names of faults, each once, the last found first.
std::vector<std::string> sensors_claimed(const Findings& findings);
/// The same for decide().
SensorsFound sensors_found(const Findings& findings);

/// What fit and tests found, for decide().
///   intervals_p  of the strongest interval, before families share the rate
TestsFound tests_found(const Findings& findings, double intervals_p, const Policy& policy = kPolicy);

}  // namespace leeway::gap
