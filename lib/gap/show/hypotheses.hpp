#pragma once

#include "gap/compare/comparison.hpp"
#include "gap/policy/options.hpp"
#include "gap/result/explanation.hpp"

/// Hypotheses as they are reported: with parameters, probabilities, sensor faults, and what would distinguish them.
namespace leeway::gap {

/// All hypotheses with their probabilities, in the order of the comparison.
void report_hypotheses(Explanation& explanation, const Comparison& comparison, std::size_t chosen,
                       const Campaign& campaign);

/// The maneuvers that would distinguish the likeliest.
///   probabilities  of all of the comparison, in its order
void plan_next(Explanation& explanation, const Comparison& comparison, const std::vector<double>& probabilities,
               const Campaign& campaign, const GapExplainOptions& options);

/// Something that the catalogue does not hold, beside what was chosen.
///   odds_of_nothing  against it
void add_unknown(Explanation& explanation, const std::vector<std::string>& beside, double odds_of_nothing);

/// Says of what the catalogue does not hold on what it depends.
void say_kind_of_unknown(Explanation& explanation);

/// Faults of sensors and conventions were corrected first: each hypothesis has them, but that nothing at all is wrong.
void add_sensors(Explanation& explanation, const Findings& findings);

/// Each hypothesis again with another fault in the place of one that these recordings do not distinguish from it; the
/// probability is shared as they predict what was left out, but the fault that was corrected keeps the largest share.
void add_rivals(Explanation& explanation, const Findings& findings);

/// Most probable first, each with those that it is not distinguished from, and in words.
void sort_hypotheses(Explanation& explanation);

}  // namespace leeway::gap
