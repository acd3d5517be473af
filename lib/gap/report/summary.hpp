#pragma once

#include <string>

#include "gap/result/explanation.hpp"

namespace leeway::gap {

/// What was found, on one screen: at most 30 lines of at most 100 characters. What does not fit is counted and left to
/// locate.json and report.html.
std::string summary(const Findings& findings);
/// The same of gap-explain, as long as what was found needs: verdict, where, what, how well before and after, what to
/// do next.
std::string summary(const Explanation& explanation);

}  // namespace leeway::gap
