#pragma once

#include <string>
#include <string_view>

#include "gap/explain.hpp"

/// The words and numbers in which findings are told, the same in JSON, summary and page.
namespace leeway::gap {

/// "mismatch", "no-mismatch", "undecided".
std::string_view word(Verdict verdict);

/// The cause of an interval in which an ensemble was not trained.
inline constexpr const char* kUntrained = "untrained region";

/// The verdict as one sentence.
std::string headline(const Findings& findings);

/// What was chosen, and whether it shows on what was held out, as one or two sentences.
std::string headline(const Explanation& explanation);

/// "fixed to the earth" for the frame "earth"; the name itself where it is not known.
std::string frame_meaning(const std::string& name);

/// The unit that a name carries, "deg/s" for "rate_bias_degps"; "1" where it carries none.
std::string unit_of(std::string_view name);

/// "1.42 +- 0.08": one digit of the standard deviation, two where it begins with 1 or 2; three digits
/// of the value where there is none.
std::string with_sd(double value, double sd);

/// "1.26 to 1.58": the limits of an interval of 95 %, as exactly as with_sd tells the value.
std::string between(double low, double high);

/// "p = 0.0021", "p < 0.0001", "p unknown".
std::string p_value(double p);

/// "37 %", "0.4 %", "< 0.1 %".
std::string percent(double share);

}  // namespace leeway::gap
