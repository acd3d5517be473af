#pragma once

#include <cstdio>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace leeway::io {

/// The whole contents of a file, "-" for the standard input. Throws IoError.
std::string read_text(const std::string& path);

/// SHA-256 of a text as 64 hexadecimal digits.
std::string sha256(std::string_view text);

/// SHA-256 of a file's contents. Throws IoError.
std::string sha256_of_file(const std::string& path);

/// File name without folder and extension, ".dat.gz" being one; "stdin" for "-".
std::string stem(const std::string& path);

/// Where symbolic links lead, also to a file that is yet to be made: a link keeps pointing to its target.
std::string link_target(const std::string& path);

/// Creates a folder and those above it. Throws IoError.
void make_directories(const std::string& path);
/// Throws IoError where make_directories() would, without creating anything: for before long work.
void require_can_make(const std::string& path);

/// A file that came with the executable, such as "lib/leeway/NAME" or "share/leeway/NAME".
std::string installed_file(const std::string& name);

/// Finds a shipped configuration: `name_or_path` as it is if such a file exists or if it looks like a path (has a '/'
/// or ends with ".json"), else <configs>/<folder>/<name>.json in the configurations that came with the executable.
/// Throws UsageError with the known names.
std::string find_config(const std::string& folder, const std::string& name_or_path);

/// The names of the shipped configurations in a folder, sorted.
std::vector<std::string> config_names(const std::string& folder);

/// A file that appears whole or not at all: it is written under a temporary name beside its place and renamed by
/// commit(). "-" is the standard output; what is not a regular file (a device, a pipe) is written directly.
class OutputFile {
 public:
  explicit OutputFile(const std::string& path);
  ~OutputFile();  ///< without commit(), nothing is left behind
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Throws IoError, or BrokenPipe where the reader of a pipe has gone.
  void write(std::string_view text);
  /// Flushes, checks, renames. Throws as write().
  void commit();
  /// The same; what before_rename() throws keeps the file that was there.
  void commit(const std::function<void()>& before_rename);

 private:
  void open_temporary();
  [[noreturn]] void fail(int error_number);

  std::string path_, target_, temporary_;
  std::FILE* file_ = nullptr;
  int lock_ = -1;  ///< keeps the temporary file locked until it has its name
};

/// Removes temporary files that killed processes left in a folder. Those of living ones are locked and stay, and so
/// does what another machine wrote within a day, whose locks may not be seen. Does so once in a process for each
/// folder.
void remove_leftovers(const std::string& folder);

/// Removes an output of an earlier run, before others that belong to it are written; not what is no regular file.
/// Throws IoError where it could not be written either, so that the others are not.
void remove_output(const std::string& path);

/// OutputFile, written and committed at once.
void write_text(const std::string& path, std::string_view text);

}  // namespace leeway::io
