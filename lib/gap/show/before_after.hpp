#pragma once

#include "gap/compare/comparison.hpp"
#include "gap/policy/options.hpp"
#include "gap/result/explanation.hpp"

namespace leeway::gap {

/// What is needed to show what an answer changes.
struct Answered {
  const Ship& ship;  ///< as it was given
  const Campaign& campaign;
  const Findings& findings;
  const FittedNull& null;
  const Comparison& comparison;
  const Fitted& answer;
  const GapExplainOptions& options;
};

/// Writes into an explanation, whose `chosen` stands, what its ship.json has more than the ship (effects, coefficients
/// and a network where what is left out in turn is followed better with them), and free runs, likelihood and coverage
/// before and after: of what was fitted, and of `heldout`, or where that is empty of each part that is left out in
/// turn. Held-out recordings are corrected in place as the others were.
void show_before_after(const Answered& answered, std::vector<Trajectory>& heldout, Explanation& explanation);

}  // namespace leeway::gap
