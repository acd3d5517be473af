#include "gap/result/numbers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

constexpr int kMostDecimals = static_cast<int>(kPolicy.report.most_decimals),
              kMostDigits = static_cast<int>(kPolicy.report.most_digits);

// That show one digit of a standard deviation, two where it begins with 1 or 2.
int decimals_of(double sd) { return -static_cast<int>(std::floor(std::log10(sd / 3.0))); }

}  // namespace

std::string unit_of(std::string_view name) {
  static constexpr std::pair<std::string_view, std::string_view> kUnits[] = {
      {"s", "s"},     {"m", "m"},         {"mps", "m/s"}, {"mps2", "m/s^2"}, {"deg", "deg"}, {"degps", "deg/s"},
      {"rad", "rad"}, {"radps", "rad/s"}, {"rps", "1/s"}, {"kn", "kn"},      {"1ps", "1/s"}, {"degps2", "deg/s^2"},
      {"N", "N"},     {"Nm", "N m"},      {"npm", "N/m"}, {"pa", "Pa"},      {"spm", "s/m"},
  };
  if (name == "C_N" || name == "c_N") return "1";  // coefficients of a moment
  const std::size_t underscore = name.rfind('_');
  if (underscore != std::string_view::npos)
    for (const auto& [suffix, unit] : kUnits)
      if (name.substr(underscore + 1) == suffix) return std::string(unit);
  return "1";
}

std::string with_sd(double value, double sd) {
  if (!std::isfinite(value)) return "unknown";
  if (!std::isfinite(sd) || sd <= 0.0) return fmt::format("{:.3g}", value);
  const int decimals = decimals_of(sd);
  if (decimals > kMostDecimals) return fmt::format("{:.2e} +- {:.1e}", value, sd);
  return fmt::format("{:.{}f} +- {:.{}f}", value, std::max(decimals, 0), sd, std::max(decimals, 0));
}

std::string rounded(double value, double sd) {
  if (!std::isfinite(value)) return "unknown";
  if (!std::isfinite(sd) || sd <= 0.0) return fmt::format("{:.3g}", value);
  const int digits = value == 0.0 ? 0 : kMostDigits - 1 - static_cast<int>(std::floor(std::log10(std::abs(value))));
  const int decimals = std::min({decimals_of(sd), digits, kMostDecimals});
  const double unit = std::pow(10.0, -decimals);
  // Without the sign of what rounds to zero.
  return fmt::format("{:.{}f}", std::round(value / unit) * unit + 0.0, std::max(decimals, 0));
}

std::string between(double low, double high) {
  const double width = high - low;
  if (!std::isfinite(width) || width <= 0.0) return fmt::format("{:.3g} to {:.3g}", low, high);
  const int decimals = decimals_of(0.25 * width);
  if (decimals > kMostDecimals) return fmt::format("{:.3e} to {:.3e}", low, high);
  return fmt::format("{:.{}f} to {:.{}f}", low, std::max(decimals, 0), high, std::max(decimals, 0));
}

std::string p_value(double p) {
  if (std::isnan(p)) return "p-value unknown";
  return p < kPolicy.report.least_p ? fmt::format("p-value < {}", kPolicy.report.least_p)
                                    : fmt::format("p-value {:.2g}", p);
}

std::string shell_word(const std::string& word) {
  constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./,:=+-@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string percent(double share) {
  if (!std::isfinite(share)) return "unknown";
  const double value = 100.0 * share;
  if (value != 0.0 && std::abs(value) < 0.1) return "< 0.1 %";
  return fmt::format("{:.{}f} %", value, std::abs(value) < 10.0 ? 1 : 0);
}

}  // namespace leeway::gap
