#pragma once

#include <string>
#include <vector>

#include "gap/decide/decide.hpp"
#include "gap/result/explanation.hpp"

namespace leeway::gap {

/// Why the tests, or the hypotheses, led to their verdict, to a person.
std::string reason_text(const Decision& decision, const TestsFound& found, const Findings& findings,
                        const std::vector<Explained>& hypotheses = {});

}  // namespace leeway::gap
