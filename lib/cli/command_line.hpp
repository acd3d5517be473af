#pragma once

#include <string>

#include <CLI/App.hpp>

namespace leeway::cli {

/// What is wrong with a command line that CLI11 has refused: a subcommand or an option that there is not, with those
/// that may have been meant, else what CLI11 says.
std::string what_is_wrong(const CLI::App& app, const CLI::ParseError& error);

}  // namespace leeway::cli
