#include "cli/command_line.hpp"

#include <algorithm>
#include <cctype>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/similar_words.hpp"

namespace leeway::cli {
namespace {

// "--u0-mps" of "--u0-mps=1"; nothing for a word that is no option, as "-0.5".
std::optional<std::string> option_name(const std::string& word) {
  if (word.size() < 2 || word[0] != '-' || word == "--") return std::nullopt;
  if (word[1] != '-' && std::isalpha(static_cast<unsigned char>(word[1])) == 0) return std::nullopt;
  return word.substr(0, word.find('='));
}

std::vector<std::string> options_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  return names;
}

std::string unknown_option(const CLI::App& app, const std::string& name) {
  std::vector<std::string> known = options_of(app);
  for (const CLI::App* sub : app.get_subcommands()) {
    const std::vector<std::string> more = options_of(*sub);
    if (std::find(more.begin(), more.end(), name) != more.end())
      return fmt::format("the option '{}' belongs to the subcommand '{}': give it behind that", name, sub->get_name());
    known.insert(known.end(), more.begin(), more.end());
  }
  return fmt::format("unknown option '{}'{}", name, did_you_mean(name, known));
}

}  // namespace

std::string what_is_wrong(const CLI::App& app, const CLI::ParseError& error) {
  std::vector<std::string> unexpected = app.remaining(true), subcommands;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    subcommands.push_back(sub->get_name());
  const bool lacks_subcommand = !subcommands.empty() && app.get_subcommands().empty();
  for (const std::string& word : unexpected) {
    const auto option = option_name(word);
    if (option) return unknown_option(app, *option);
    if (lacks_subcommand)
      return fmt::format("unknown subcommand '{}'; known: {}{}", word, fmt::join(subcommands, ", "),
                         did_you_mean(word, subcommands));
  }
  return error.what();
}

}  // namespace leeway::cli
