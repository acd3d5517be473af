#pragma once

#include <string>

#include "gap/decide/decide.hpp"
#include "gap/result/findings.hpp"

namespace leeway::gap {

/// Why the tests led to their verdict, to a person.
std::string reason_text(const Decision& decision, const TestsFound& found, const Findings& findings);

}  // namespace leeway::gap
