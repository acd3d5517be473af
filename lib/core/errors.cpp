#include "core/errors.hpp"

#include <fmt/format.h>

namespace leeway {

InputError::InputError(const std::string& file, std::size_t line, const std::string& item, const std::string& problem)
    : std::runtime_error(fmt::format("{}{}: {}{}{}", file, line > 0 ? fmt::format(":{}", line) : "", item,
                                     item.empty() ? "" : ": ", problem)) {}

InputError::InputError(const std::string& file, const std::string& problem) : InputError(file, 0, "", problem) {}

IoError::IoError(const std::string& file, const std::string& problem)
    : std::runtime_error(fmt::format("{}: {}", file, problem)) {}

}  // namespace leeway
