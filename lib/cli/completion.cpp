#include "cli/completion.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "effects/description.hpp"
#include "io/files.hpp"
#include "nn/rollout.hpp"

namespace leeway::cli {
namespace {

// Options and positionals whose value may be the name of a shipped configuration, and the folder that it is in.
const std::map<std::string, std::string> kConfigFolders{
    {"--ship", "ships"},    {"ship", "ships"},    {"--base", "ships"},  {"--columns", "columns"},
    {"--config", "train"},  {"--noise", "noise"}, {"spec", "datasets"}, {"particulars", "particulars"},
    {"--without", "hulls"},
};

// Values that are texts, but names of neither files nor anything else.
const std::set<std::string> kWithoutFiles{"--kernel", "--base-spread", "--kp", "--kd", "--without", "effect"};

bool begins(const std::string& text, const std::string& start) { return text.compare(0, start.size(), start) == 0; }

// "a" and "b" of a type "TEXT:{a,b}", as CLI11 writes it for a set of words.
std::vector<std::string> choices_of(const std::string& type) {
  std::vector<std::string> choices;
  const std::size_t open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos) return choices;
  for (std::size_t begin = open + 1; begin < close;) {
    const std::size_t end = std::min(type.find(',', begin), close);
    choices.push_back(type.substr(begin, end - begin));
    begin = end + 1;
  }
  return choices;
}

// The values of an option or a positional.
Completion values_of(const CLI::Option& option) {
  const std::string name = option.get_name(), type = option.get_type_name();
  if (std::vector<std::string> choices = choices_of(type); !choices.empty()) return {std::move(choices), false};
  Completion values;
  values.files = begins(type, "TEXT") && !kWithoutFiles.contains(name);
  if (const auto folder = kConfigFolders.find(name); folder != kConfigFolders.end())
    values.words = io::config_names(folder->second);
  if (name == "effect")
    for (const EffectDescription& effect : effect_catalogue()) values.words.emplace_back(effect.info.name);
  if (name == "--kernel") {
    values.words = nn::available_kernels();
    values.words.emplace_back("auto");
  }
  return values;
}

std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  return names;
}

// Where a command line stands before its last word.
class Position {
 public:
  explicit Position(const CLI::App& app) : level_(&app) {}

  void pass(const std::string& word) {
    if (value_of_ != nullptr) {
      value_of_ = nullptr;
    } else if (begins(word, "-") && word.size() > 1) {
      const CLI::Option* option = option_named(word.substr(0, word.find('=')));
      if (option == nullptr) return;
      given_.insert(option);
      if (option->get_items_expected_max() > 0 && word.find('=') == std::string::npos) value_of_ = option;
    } else if (const std::vector<const CLI::App*> subs = subcommands(word); !subs.empty()) {
      level_ = subs.front();
    } else {
      ++positionals_;
    }
  }

  Completion candidates(const std::string& word) const {
    if (value_of_ != nullptr) return values_of(*value_of_);
    if (begins(word, "-")) return {options(), false};
    if (const auto subs = subcommands(); !subs.empty()) {
      Completion names;
      for (const CLI::App* sub : subs) names.words.push_back(sub->get_name());
      return names;
    }
    const CLI::Option* const positional = positional_here();
    return positional == nullptr ? Completion{} : values_of(*positional);
  }

 private:
  template <typename Visit>
  void for_each_option(const Visit& visit) const {
    for (const CLI::App* app = level_; app != nullptr; app = app->get_parent())
      for (const CLI::Option* option : app->get_options()) visit(*option);
  }

  const CLI::Option* option_named(const std::string& name) const {
    const CLI::Option* found = nullptr;
    for_each_option([&](const CLI::Option& option) {
      const std::vector<std::string> names = names_of(option);
      if (std::find(names.begin(), names.end(), name) != names.end()) found = &option;
    });
    return found;
  }

  // Those that are not given yet, or may be given again.
  std::vector<std::string> options() const {
    std::set<std::string> names;
    for_each_option([&](const CLI::Option& option) {
      const bool is_over =
          given_.contains(&option) && option.get_multi_option_policy() != CLI::MultiOptionPolicy::TakeAll;
      if (is_over || option.get_group().empty()) return;
      for (const std::string& name : names_of(option)) names.insert(name);
    });
    return {names.begin(), names.end()};
  }

  // All of them, or the one of this name.
  std::vector<const CLI::App*> subcommands(const std::string& name = "") const {
    return level_->get_subcommands([&](const CLI::App* sub) { return name.empty() || sub->get_name() == name; });
  }

  const CLI::Option* positional_here() const {
    std::size_t first = 0;
    for (const CLI::Option* option : level_->get_options()) {
      if (!option->get_positional()) continue;
      first += static_cast<std::size_t>(std::max(1, option->get_items_expected_max()));
      if (positionals_ < first) return option;
    }
    return nullptr;
  }

  const CLI::App* level_;
  const CLI::Option* value_of_ = nullptr;  // of this the next word is the value
  std::set<const CLI::Option*> given_;
  std::size_t positionals_ = 0;
};

}  // namespace

Completion complete(const CLI::App& app, const std::vector<std::string>& words) {
  Position position(app);
  for (std::size_t i = 0; i + 1 < words.size(); ++i) position.pass(words[i]);
  const std::string word = words.empty() ? "" : words.back();
  Completion completion = position.candidates(word);
  std::erase_if(completion.words, [&](const std::string& candidate) { return !begins(candidate, word); });
  return completion;
}

std::string completion_text(const CLI::App& app, const std::vector<std::string>& words) {
  const Completion completion = complete(app, words);
  std::string text = completion.files ? "files\n" : "words\n";
  for (const std::string& word : completion.words) text += word + '\n';
  return text;
}

}  // namespace leeway::cli
