#include "cli/inputs.hpp"

#include "io/dataset_json.hpp"
#include "io/files.hpp"
#include "io/outputs.hpp"

namespace leeway::cli {

Inputs& Inputs::recordings(const std::vector<std::string>& arguments) { return files(io::named_files(arguments)); }

Inputs& Inputs::config(const std::string& folder, const std::string& name_or_path) {
  if (!name_or_path.empty()) files_.push_back(io::find_config(folder, name_or_path));
  return *this;
}

Inputs& Inputs::files(const std::vector<std::string>& paths) {
  files_.insert(files_.end(), paths.begin(), paths.end());
  return *this;
}

Inputs& Inputs::folder(const std::string& path) { return files(io::files_in(path)); }

void Inputs::keep_from(const std::vector<std::string>& outputs) const { io::require_apart(files_, outputs); }

}  // namespace leeway::cli
