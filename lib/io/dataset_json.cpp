#include "io/dataset_json.hpp"

#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "io/json.hpp"

namespace leeway::io {
namespace fs = std::filesystem;
namespace {

// Keys that describe a dataset and that no reader needs; any other unknown key is an error.
void pass_over_descriptions(const JsonObject& object) {
  for (const char* key : {"name", "description", "source", "ship", "maneuver", "noise", "seed", "spec", "provenance"})
    object.has(key);
  object.check_all_known();
}

}  // namespace

std::string set_of_path(const std::string& path) {
  std::error_code error;
  fs::path folder = fs::absolute(path, error).parent_path();
  if (folder.filename() == "truth") folder = folder.parent_path();
  return folder.filename().string();
}

std::vector<RecordingFile> expand_recordings(const std::vector<std::string>& arguments) {
  std::vector<RecordingFile> result;
  for (const std::string& argument : arguments) {
    const std::size_t hash = argument.rfind(".json#");
    const std::string path = hash == std::string::npos ? argument : argument.substr(0, hash + 5);
    if (!path.ends_with(".json")) {
      result.push_back({argument, "", set_of_path(argument)});
      continue;
    }
    const std::string wanted = hash == std::string::npos ? "" : argument.substr(hash + 6);
    const Json json = read_json(path);
    const JsonObject dataset(json, path);
    const fs::path folder = fs::path(path).parent_path();
    std::vector<std::string> names;
    const std::size_t before = result.size();
    for (const JsonObject& set : dataset.objects("sets")) {
      const std::string name = set.text("name");
      names.push_back(name);
      for (const JsonObject& recording : set.objects("recordings")) {
        const std::string truth = recording.text_or("truth", "");
        const std::string file = recording.text("file");
        if (wanted.empty() || name == wanted)
          result.push_back({(folder / file).string(), truth.empty() ? "" : (folder / truth).string(), name});
        pass_over_descriptions(recording);
      }
      pass_over_descriptions(set);
    }
    pass_over_descriptions(dataset);
    if (result.size() == before)
      throw InputError(path, wanted.empty() ? "lists no recording"
                                            : fmt::format("no set '{}'; sets: {}", wanted, fmt::join(names, ", ")));
  }
  return result;
}

}  // namespace leeway::io
