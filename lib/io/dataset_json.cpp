#include "io/dataset_json.hpp"

#include <filesystem>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "io/csv.hpp"
#include "io/json.hpp"
#include "io/result_folder.hpp"

namespace leeway::io {
namespace fs = std::filesystem;
namespace {

// Keys that describe a dataset and that no reader needs; any other unknown key is an error.
void pass_over_descriptions(const JsonObject& object) {
  for (const char* key :
       {"name", "description", "source", "ship", "maneuver", "noise", "seed", "spec", "provenance", "parts"})
    object.has(key);
  object.check_all_known();
}

fs::path folder_of(const std::string& path) {
  std::error_code error;
  return fs::absolute(path, error).parent_path();
}

bool is_of_truths(const fs::path& folder) { return folder.filename() == "truth"; }

}  // namespace

std::string_view word(States states) {
  return states == States::truth ? "truth" : states == States::observations ? "observations" : "unstated";
}

std::string set_of_path(const std::string& path) {
  const fs::path folder = folder_of(path);
  return (is_of_truths(folder) ? folder.parent_path() : folder).filename().string();
}

std::vector<RecordingFile> expand_recordings(const std::vector<std::string>& arguments) {
  std::vector<RecordingFile> result;
  for (const std::string& argument : arguments) {
    std::error_code error;
    // What lies there under the whole name is meant.
    const std::size_t hash = fs::exists(argument, error) ? std::string::npos : argument.rfind(".json#");
    const std::string path = hash == std::string::npos ? argument : argument.substr(0, hash + 5);
    if (!path.ends_with(".json")) {
      const States states = is_of_truths(folder_of(argument)) ? States::truth : States::unstated;
      result.push_back({argument, "", set_of_path(argument), "", states});
      continue;
    }
    const std::string wanted = hash == std::string::npos ? "" : argument.substr(hash + 6);
    const Json json = read_json(path);
    const JsonObject dataset(json, path);
    const fs::path folder = fs::path(path).parent_path();
    const std::map<std::string, std::string> parts = parts_of(dataset);
    std::vector<std::string> names;
    const std::size_t before = result.size();
    for (const JsonObject& set : dataset.objects("sets")) {
      const std::string name = set.text("name");
      names.push_back(name);
      for (const JsonObject& recording : set.objects("recordings")) {
        const std::string truth = recording.text_or("truth", "");
        const std::string file = recording.text("file");
        const bool is_wanted = wanted.empty() || name == wanted;
        for (const std::string& part : {file, truth})
          if (const auto named = parts.find(part); is_wanted && named != parts.end())
            require_unchanged((folder / part).string(), named->second, path);
        if (is_wanted)
          result.push_back({(folder / file).string(), truth.empty() ? "" : (folder / truth).string(), name, path,
                            States::observations});
        pass_over_descriptions(recording);
      }
      pass_over_descriptions(set);
    }
    pass_over_descriptions(dataset);
    if (result.size() == before)
      throw InputError(
          path, wanted.empty() ? "lists no recording" : fmt::format("no set '{}'; sets: {}", wanted, listed(names)));
  }
  return result;
}

std::vector<std::string> named_files(const std::vector<std::string>& arguments) {
  std::vector<std::string> files;
  std::set<std::string> datasets;
  for (const RecordingFile& recording : expand_recordings(arguments))
    if (recording.dataset.empty())
      files.push_back(recording.path);
    else
      datasets.insert(recording.dataset);
  for (const RecordingFile& recording : expand_recordings({datasets.begin(), datasets.end()})) {
    files.push_back(recording.path);
    if (!recording.truth.empty()) files.push_back(recording.truth);
  }
  files.insert(files.end(), datasets.begin(), datasets.end());
  return files;
}

}  // namespace leeway::io
