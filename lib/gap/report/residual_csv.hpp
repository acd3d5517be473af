#pragma once

#include <string>

#include "gap/result/findings.hpp"

namespace leeway::gap {

/// The text of residual.csv: time, residual acceleration and force per axis with their standard deviations, smoothed
/// states under the names of a trajectory CSV. Columns and units in docs/gap-locate.md. What is missing is an empty
/// field.
std::string residual_text(const Residual& residual);

}  // namespace leeway::gap
