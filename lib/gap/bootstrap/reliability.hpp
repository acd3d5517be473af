#pragma once

#include <vector>

#include "gap/result/bootstrap.hpp"

namespace leeway::gap {

/// How stated probabilities have to be sharpened or blunted to be true of these campaigns: `sharpness` and `not_fitted`
/// of a Bootstrap, from its campaigns. The likeliest sharpness, whose logarithm is normal about none with
/// kPolicy.bootstrap.sharpness_log_sd before any campaign; Jeffreys' estimate of the share that was not fitted.
void fit_reliability(Bootstrap& bootstrap);

/// What the bootstrap makes of stated probabilities.
std::vector<double> as_realized(const Bootstrap& bootstrap, std::vector<double> stated);

}  // namespace leeway::gap
