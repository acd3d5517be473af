#pragma once

#include <string>
#include <vector>

#include "gap/result/explanation.hpp"

namespace leeway::gap {

/// What to do, with a command that runs as it stands; either may be empty.
struct Step {
  std::string label, text, command;
};
std::vector<Step> steps(const Findings& findings);
std::vector<Step> steps(const Explanation& explanation);

/// What was found, on one screen: at most 30 lines of at most 100 characters. What does not fit is counted and left to
/// locate.json and report.html.
std::string summary(const Findings& findings);
/// The same of gap-explain: verdict, where, what, how well before and after, what to do next.
std::string summary(const Explanation& explanation);

}  // namespace leeway::gap
