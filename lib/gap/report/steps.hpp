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

/// Whether ship.json differs from the ship as it was.
bool changes_ship(const Explanation& explanation);

}  // namespace leeway::gap
