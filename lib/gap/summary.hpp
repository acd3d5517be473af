#pragma once

#include <string>

#include "gap/findings.hpp"

namespace leeway::gap {

/// What was found, on one screen: at most 30 lines of at most 100 characters. What does not fit is counted and left to
/// locate.json and report.html.
std::string summary(const Findings& findings);

}  // namespace leeway::gap
