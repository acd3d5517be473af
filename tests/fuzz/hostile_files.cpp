#include "fuzz/hostile_files.hpp"

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <sys/mman.h>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

namespace leeway::test {
namespace fs = std::filesystem;

HostileFiles::HostileFiles() {
  static std::atomic<int> number{0};
  folder_ = fmt::format("{}/leeway-fuzz-{}-{}", fs::temp_directory_path().string(), ::getpid(), number++);
  fs::remove_all(folder_);
  fs::create_directories(folder_);
}

HostileFiles::~HostileFiles() {
  for (const auto& [name, fd] : files_) ::close(fd);
  std::error_code error;
  fs::remove_all(folder_, error);
}

std::string HostileFiles::write(const std::string& name, std::string_view text) {
  const auto [file, is_new] = files_.try_emplace(name, -1);
  if (is_new) {
    file->second = ::memfd_create(name.c_str(), MFD_CLOEXEC);
    fs::create_symlink(fmt::format("/proc/{}/fd/{}", ::getpid(), file->second), path(name));
  }
  const auto size = static_cast<ssize_t>(text.size());
  if (::pwrite(file->second, text.data(), text.size(), 0) != size || ::ftruncate(file->second, size) != 0)
    throw std::system_error(errno, std::generic_category(), path(name));
  return path(name);
}

void HostileFiles::remove(const std::string& name) {
  const auto file = files_.find(name);
  if (file == files_.end()) return;
  ::close(file->second);
  files_.erase(file);
  fs::remove(path(name));
}

}  // namespace leeway::test
