#include "core/errors.hpp"

namespace leeway {

InputError::InputError(const std::string& file, std::size_t line, const std::string& item, const std::string& problem)
    : std::runtime_error([&] {
        std::string text = file;
        if (line > 0) text.append(":").append(std::to_string(line));
        text.append(": ");
        if (!item.empty()) text.append(item).append(": ");
        return text.append(problem);
      }()) {}

InputError::InputError(const std::string& file, const std::string& problem) : InputError(file, 0, "", problem) {}

IoError::IoError(const std::string& file, const std::string& problem)
    : std::runtime_error(std::string(file).append(": ").append(problem)) {}

}  // namespace leeway
