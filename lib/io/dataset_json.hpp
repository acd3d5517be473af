#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace leeway::io {

/// What is known of the states in a file: they are the simulator's own, or they were measured; or nobody says.
enum class States { truth, observations, unstated };
/// "truth", "observations", "unstated".
std::string_view word(States states);

/// A recording that the command line or a dataset names.
struct RecordingFile {
  std::string path;
  std::string truth;         ///< noise-free states of the same run; empty where there are none
  std::string set;           ///< data set it belongs to: the set's name, or the folder of the file
  std::string dataset = "";  ///< the dataset.json that lists it; empty where none does
  /// Of `path`: observations where a dataset.json lists it. A file alone is a truth in a folder of that name, where
  /// data sets have theirs; elsewhere nobody says.
  States states = States::unstated;
};

/// Expands what stands on a command line into recordings: a CSV file stands for itself, a dataset.json for all that
/// it lists, and dataset.json#SET for one of its sets; a file that has such a name is meant itself. Paths in a dataset
/// are relative to its folder.
std::vector<RecordingFile> expand_recordings(const std::vector<std::string>& arguments);

/// All files that the arguments name: recordings, their truths, and each dataset.json with all that its sets list.
std::vector<std::string> named_files(const std::vector<std::string>& arguments);

/// The data set of a file that no dataset.json lists: its folder's name, or that of the folder above "truth".
std::string set_of_path(const std::string& path);

}  // namespace leeway::io
