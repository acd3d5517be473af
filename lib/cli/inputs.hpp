#pragma once

#include <string>
#include <vector>

namespace leeway::cli {

/// What a tool reads, so that no output is written over it. Every tool states all of it before it begins to work.
class Inputs {
 public:
  /// CSV files, "-", dataset.json or dataset.json#SET.
  Inputs& recordings(const std::vector<std::string>& arguments);
  /// A JSON file or a shipped name, as for io::find_config(); "" is none.
  Inputs& config(const std::string& folder, const std::string& name_or_path);
  Inputs& files(const std::vector<std::string>& paths);
  /// All files of a folder, as a model directory.
  Inputs& folder(const std::string& path);

  /// Throws UsageError as io::require_apart().
  void keep_from(const std::vector<std::string>& outputs) const;

 private:
  std::vector<std::string> files_;
};

}  // namespace leeway::cli
