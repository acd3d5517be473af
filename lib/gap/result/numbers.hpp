#pragma once

#include <string>
#include <string_view>

/// Numbers as they are written everywhere.
namespace leeway::gap {

/// The unit that a name carries, "deg/s" for "rate_bias_degps"; "1" where it carries none.
std::string unit_of(std::string_view name);

/// "1.42 +- 0.08": one digit of the standard deviation, two where it begins with 1 or 2; three digits
/// of the value where there is none.
std::string with_sd(double value, double sd);

/// "1.42", "130": the value alone, rounded as with_sd does, also to tens and hundreds; three digits at most.
std::string rounded(double value, double sd);

/// "1.26 to 1.58": the limits of an interval of 95 %, as exactly as with_sd has the value.
std::string between(double low, double high);

/// "p-value 0.0021", "p-value < 0.0001", "p-value unknown".
std::string p_value(double p);

/// A word as a shell takes it: in single quotes where it needs them.
std::string shell_word(const std::string& word);

/// "37 %", "0.4 %", "< 0.1 %".
std::string percent(double share);

}  // namespace leeway::gap
