#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>

namespace leeway::cli {

/// What a word that is being typed can become.
struct Completion {
  std::vector<std::string> words;
  bool files = false;  ///< names of files as well
};

/// Completes the last word of a command line, by the subcommands and options that the tool itself reads.
///   words  those behind the tool's name; the last one as far as it is typed, maybe empty
Completion complete(const CLI::App& app, const std::vector<std::string>& words);

/// `TOOL --complete WORD...` is how a shell asks for it (packaging/leeway.bash): "files" or "words" on a line, then one
/// candidate per line.
inline constexpr const char* kComplete = "--complete";
std::string completion_text(const CLI::App& app, const std::vector<std::string>& words);

}  // namespace leeway::cli
