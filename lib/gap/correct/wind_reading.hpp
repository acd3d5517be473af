#pragma once

#include <optional>

#include "gap/fit/null_fit.hpp"
#include "gap/policy/options.hpp"

namespace leeway::gap {

/// ln of the evidence of the best of nothing missing and the effects with the largest expected gains, fitted.
///   fit  of the campaign, with nothing missing
double best_evidence(const Campaign& campaign, const FittedNull& fit, const GapLocateOptions& options);

/// A wind that is weak against the ship's forces is not identified over short times, but by the fit: the reading under
/// which all is far likelier, with coefficients and model error fitted to it. Waves that come against the wind look
/// like one: it has to be likelier also where one effect may be missing.
///   fit  of the campaign as stated, where the fits of other readings begin
std::optional<Reading> wind_reading(const Campaign& campaign, const FittedNull& fit, const Conventions& conventions,
                                    const GapLocateOptions& options);

}  // namespace leeway::gap
