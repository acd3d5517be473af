#pragma once

#include <string>
#include <vector>

#include "gap/compare/fitted.hpp"
#include "gap/result/findings.hpp"

/// Forces of unknown begin and end: effects that are bound to a time, as a tug.
namespace leeway::gap {

/// Starts beside a fit with such an effect, of unknown force, direction and point of action, in each of some intervals
/// of different recordings, whose ends are moved to where it explains most.
std::vector<Start> starts_in_intervals(const Campaign& campaign, const Fitted& fitted, const std::string& effect,
                                       const std::vector<Interval>& intervals, std::size_t jobs);

/// With what a tug is known by now, its begin and end are known better than they were sought: pieces with its force, or
/// against it, are tried at both ends, all in one pass, until none gains.
void refine_tugs(const Campaign& campaign, const FitOptions& options, Fitted& fitted);

}  // namespace leeway::gap
