#include "core/errors.hpp"

#include <fmt/format.h>

namespace leeway {

namespace {

// What a message says is text up to its first NUL byte: one that stands in a file is shown.
std::string shown(const std::string& text) {
  std::string result;
  for (const char c : text)
    if (c == '\0')
      result += "\\0";
    else
      result += c;
  return result;
}

}  // namespace

InputError::InputError(const std::string& file, std::size_t line, const std::string& item, const std::string& problem)
    : std::runtime_error(shown(fmt::format("{}{}: {}{}{}", file, line > 0 ? fmt::format(":{}", line) : "", item,
                                           item.empty() ? "" : ": ", problem))) {}

InputError::InputError(const std::string& file, const std::string& problem) : InputError(file, 0, "", problem) {}

IoError::IoError(const std::string& file, const std::string& problem)
    : std::runtime_error(fmt::format("{}: {}", file, problem)) {}

}  // namespace leeway
