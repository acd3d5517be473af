#pragma once

#include <string>
#include <vector>

namespace leeway::io {

/// A recording that the command line or a dataset names.
struct RecordingFile {
  std::string path;
  std::string truth;  ///< noise-free states of the same run; empty where there are none
  std::string set;    ///< data set it belongs to: the set's name, or the folder of the file
};

/// Expands what stands on a command line into recordings: a CSV file stands for itself, a dataset.json for all that
/// it lists, and dataset.json#SET for one of its sets. Paths in a dataset are relative to its folder.
std::vector<RecordingFile> expand_recordings(const std::vector<std::string>& arguments);

/// The data set of a file that no dataset.json lists: its folder's name, or that of the folder above "truth".
std::string set_of_path(const std::string& path);

}  // namespace leeway::io
