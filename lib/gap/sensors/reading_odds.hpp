#pragma once

#include <functional>
#include <vector>

#include "gap/decide/sensors.hpp"
#include "gap/result/sensor_findings.hpp"
#include "gap/sensors/readings.hpp"

/// How well readings fit, one against another.
namespace leeway::gap {

/// Errors of one way to read, one per block; NaN where a block has no data.
using BlockErrors = std::vector<double>;

double total_error(const BlockErrors& errors);
std::size_t blocks_with_data(const BlockErrors& errors);

using Odds = ReadingTest;

/// Of one way to read against another. Within a block errors last, so that it counts as two independent ones.
Odds odds_of(const BlockErrors& better, const BlockErrors& worse);

/// A reading that was tested.
///   what  was compared: "the forces", ...
Reading reading_of(const ReadingEntry& entry, const Odds& odds, const char* what);

/// Puts a reading among the tested; a later test of the same one, with others corrected, replaces the earlier.
void note_tested(Conventions& result, const Reading& reading);

/// One reading for each question, or the stated one.
using Combination = std::vector<const ReadingEntry*>;

/// Finds the combination that explains the errors with the fewest changes, and claims what is decisive in it.
///   groups  of which a combination takes one reading each, or none
///   errors  of the recordings read by a combination; several lists, each against its own scale
///   returns the readings claimed
Combination claimed_of(const std::vector<Combination>& groups,
                       const std::function<std::vector<BlockErrors>(const Combination&)>& errors, const char* what,
                       Conventions& result);

}  // namespace leeway::gap
