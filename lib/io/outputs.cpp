#include "io/outputs.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "io/files.hpp"

namespace leeway::io {
namespace fs = std::filesystem;
namespace {

// Equal for two paths that lead to one file, whether or not it is there yet; empty for what is no regular file, which
// cannot be written over.
std::string identity(const std::string& path, int stream) {
  struct stat status {};
  if ((path == "-" ? ::fstat(stream, &status) : ::stat(path.c_str(), &status)) == 0)
    return S_ISREG(status.st_mode) ? fmt::format("{}:{}", status.st_dev, status.st_ino) : "";
  std::error_code error;
  const fs::path canonical = fs::weakly_canonical(fs::absolute(link_target(path), error), error);
  return error ? "" : canonical.string();
}

}  // namespace

void require_apart(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs) {
  std::map<std::string, std::string> read, written;
  for (const std::string& input : inputs) {
    const std::string id = input.empty() ? "" : identity(input, STDIN_FILENO);
    if (!id.empty()) read.emplace(id, input);
  }
  const auto name = [](const std::string& path, const char* stream) { return path == "-" ? stream : path; };
  for (const std::string& output : outputs) {
    const std::string id = output.empty() ? "" : identity(output, STDOUT_FILENO);
    if (id.empty()) continue;
    if (const auto input = read.find(id); input != read.end())
      throw UsageError(fmt::format("{}: is also the input {}, and no input is written over; choose another output",
                                   name(output, "standard output"), name(input->second, "on the standard input")));
    if (const auto [other, is_new] = written.emplace(id, output); !is_new)
      throw UsageError(fmt::format("{}: two outputs go to one file ({}); choose another for one of them",
                                   name(output, "standard output"), name(other->second, "standard output")));
  }
}

std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error, other;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file(other)) files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace leeway::io
