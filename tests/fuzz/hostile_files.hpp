#pragma once

#include <map>
#include <string>
#include <string_view>

namespace leeway::test {

/// A folder whose files lie in memory, so that millions of readings touch no disk: links to memfd_create().
class HostileFiles {
 public:
  HostileFiles();
  ~HostileFiles();
  HostileFiles(const HostileFiles&) = delete;
  HostileFiles& operator=(const HostileFiles&) = delete;

  /// The folder's path; every message of a reader begins with it.
  const std::string& folder() const { return folder_; }
  /// Writes a file and returns its path.
  std::string write(const std::string& name, std::string_view text);
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  void remove(const std::string& name);

 private:
  std::string folder_;
  std::map<std::string, int> files_;
};

}  // namespace leeway::test
