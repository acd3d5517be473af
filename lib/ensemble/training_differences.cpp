#include "ensemble/training_differences.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/csv.hpp"
#include "io/files.hpp"

namespace leeway::ensemble {
namespace {

// "sigma/u_mps" of each setting but those that decide nothing.
std::map<std::string, std::string> settings_of(const TrainingConfig& config) {
  io::Json json = to_json(config);
  json.erase("members");
  json.erase("follows");
  std::map<std::string, std::string> settings;
  const io::Json flat = json.flatten();
  for (const auto& [pointer, value] : flat.items())  // angles come back from a file with another last digit
    settings[pointer.substr(1)] = value.is_number_float() ? fmt::format("{:.10g}", value.get<double>()) : value.dump();
  return settings;
}

void add_settings(const EnsembleHeader& found, const EnsembleHeader& expected, std::vector<std::string>& differences) {
  const std::map<std::string, std::string> there = settings_of(found.config), here = settings_of(expected.config);
  const auto value_in = [](const auto& settings, const std::string& key) {
    const auto at = settings.find(key);
    return at == settings.end() ? std::string("none") : at->second;
  };
  std::map<std::string, std::string> all = here;
  all.insert(there.begin(), there.end());
  for (const auto& [key, value] : all)
    if (value_in(here, key) != value_in(there, key))
      differences.push_back(fmt::format("{}: expected {}, found {}", key, value_in(here, key), value_in(there, key)));
}

void add_recordings(const EnsembleHeader& found, const EnsembleHeader& expected,
                    std::vector<std::string>& differences) {
  std::map<std::string, std::string> there, here;  // hash by name
  for (const TrainingFile& file : found.files) there[file.file] = file.sha256;
  for (const TrainingFile& file : expected.files) here[io::stem(file.file)] = file.sha256;
  std::vector<std::string> lacking, more, other;
  for (const auto& [name, hash] : here) {
    const auto at = there.find(name);
    if (at == there.end())
      lacking.push_back(name);
    else if (at->second != hash)
      other.push_back(
          fmt::format("{} (SHA-256 expected {}, found {})", name, hash.substr(0, 8), at->second.substr(0, 8)));
  }
  for (const auto& [name, hash] : there)
    if (!here.contains(name)) more.push_back(name);
  if (!lacking.empty())
    differences.push_back(fmt::format("recordings expected and not found: {}", io::listed(lacking)));
  if (!more.empty()) differences.push_back(fmt::format("recordings found and not expected: {}", io::listed(more)));
  if (!other.empty()) differences.push_back(fmt::format("recordings of other contents: {}", io::listed(other)));
}

}  // namespace

std::vector<std::string> training_differences(const EnsembleHeader& found, const EnsembleHeader& expected) {
  std::vector<std::string> differences;
  add_settings(found, expected, differences);
  if (found.seed != expected.seed)
    differences.push_back(fmt::format("seed: expected {}, found {}", expected.seed, found.seed));
  add_recordings(found, expected, differences);
  return differences;
}

}  // namespace leeway::ensemble
