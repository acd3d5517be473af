#pragma once

#include <vector>

#include "gap/policy/options.hpp"
#include "gap/result/explanation.hpp"

/// What gap-explain adds to gap-locate: hypotheses about what is missing, compared, chosen and shown to help.
namespace leeway::gap {

/// All of gap-explain. Recordings are corrected in place where sensor faults are found, `heldout` with them. Throws
/// what gap_locate() throws.
Explanation gap_explain(const Ship& ship, std::vector<Trajectory>& recordings, std::vector<Trajectory>& heldout,
                        const GapExplainOptions& options);

}  // namespace leeway::gap
