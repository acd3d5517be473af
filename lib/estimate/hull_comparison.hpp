#pragma once

#include "estimate/measured_hulls.hpp"

namespace leeway::estimate {

/// Each measured hull estimated, with widths fitted without it: {"hulls": [{"name", "source", "coefficients": [{"name",
/// "estimated", "measured", "error", "sd", "is_absolute", "hulls", "within_95"}]}], "within_95", "coefficients"}.
io::Json compare_measured_hulls(const std::vector<MeasuredHull>& hulls);

}  // namespace leeway::estimate
