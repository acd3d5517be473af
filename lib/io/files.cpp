#include "io/files.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <memory>
#include <random>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>
#include <openssl/evp.h>

#include "core/errors.hpp"

namespace leeway::io {
namespace fs = std::filesystem;
namespace {

std::string configs_folder() {
  std::error_code error;
  const fs::path executable = fs::read_symlink("/proc/self/exe", error);
  return (executable.parent_path().parent_path() / "share/leeway/configs").string();
}

struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd != STDIN_FILENO) ::close(fd);
  }
};

// Hands a file ("-": standard input) over piece by piece.
template <typename Take>
void read_chunks(const std::string& path, const Take& take) {
  const Descriptor file{path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.fd < 0) throw IoError(path, fmt::format("cannot be opened: {}", std::strerror(errno)));
  std::vector<char> buffer(1 << 18);
  for (;;) {
    const ssize_t got = ::read(file.fd, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw IoError(path, fmt::format("cannot be read: {}", std::strerror(errno)));
    if (got == 0) return;
    take(std::string_view(buffer.data(), static_cast<std::size_t>(got)));
  }
}

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    check(context_ != nullptr && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
  }
  void add(std::string_view text) { check(EVP_DigestUpdate(context_.get(), text.data(), text.size()) == 1); }
  std::string hex() {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned int length = 0;
    check(EVP_DigestFinal_ex(context_.get(), digest, &length) == 1);
    std::string text;
    for (unsigned int i = 0; i < length; ++i) text += fmt::format("{:02x}", digest[i]);
    return text;
  }

 private:
  static void check(bool ok) {
    if (!ok) throw std::runtime_error("SHA-256 is not available");
  }
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

std::string read_text(const std::string& path) {
  std::string text;
  read_chunks(path, [&](std::string_view chunk) { text += chunk; });
  return text;
}

std::string sha256(std::string_view text) {
  Sha256 hash;
  hash.add(text);
  return hash.hex();
}

std::string sha256_of_file(const std::string& path) {
  Sha256 hash;
  read_chunks(path, [&](std::string_view chunk) { hash.add(chunk); });
  return hash.hex();
}

std::string stem(const std::string& path) { return path == "-" ? "stdin" : fs::path(path).stem().string(); }

void require_can_make(const std::string& path) {
  std::error_code error;
  fs::path there = fs::absolute(path, error).lexically_normal();
  while (!fs::exists(there, error) && there.has_relative_path()) there = there.parent_path();
  if (!fs::is_directory(there, error)) throw IoError(path, fmt::format("'{}' is not a folder", there.string()));
  if (::access(there.c_str(), W_OK | X_OK) != 0)
    throw IoError(path, fmt::format("nothing can be written in '{}': {}", there.string(), std::strerror(errno)));
}

void make_directories(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw IoError(path, fmt::format("cannot be created: {}", error.message()));
  if (!fs::is_directory(path, error)) throw IoError(path, "is not a folder");
}

std::vector<std::string> config_names(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(configs_folder()) / folder, error))
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string find_config(const std::string& folder, const std::string& name_or_path) {
  std::error_code error;
  const bool looks_like_path = name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".json");
  if (looks_like_path || name_or_path == "-" || fs::is_regular_file(name_or_path, error)) return name_or_path;
  const fs::path shipped = fs::path(configs_folder()) / folder / (name_or_path + ".json");
  if (fs::exists(shipped, error)) return shipped.string();
  throw UsageError(fmt::format("no file '{}', and no shipped configuration of that name in configs/{}; shipped: {}",
                               name_or_path, folder, fmt::join(config_names(folder), ", ")));
}

OutputFile::OutputFile(const std::string& path) : path_(path) {
  if (path == "-") {
    file_ = stdout;
    return;
  }
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) throw IoError(path, "is a folder, expected a file");
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    file_ = std::fopen(path.c_str(), "wb");
    if (file_ == nullptr) fail(errno);
    return;
  }
  // A link keeps pointing to its target: the temporary file lies beside the target, even if that is yet to be made.
  target_ = path;
  for (int links = 0; links < 40 && fs::is_symlink(target_, error); ++links) {
    const fs::path next = fs::read_symlink(target_, error);
    target_ = (fs::path(target_).parent_path() / next).string();
  }
  if (fs::exists(status) && ::access(target_.c_str(), W_OK) != 0) fail(errno);
  // Processes of other machines may write the same file of a shared folder under the same process number.
  temporary_ = fmt::format("{}.{}-{:08x}.tmp", target_, ::getpid(), std::random_device{}());
  file_ = std::fopen(temporary_.c_str(), "wbx");
  if (file_ == nullptr) {
    temporary_.clear();
    fail(errno);
  }
  if (fs::exists(status)) ::fchmod(::fileno(file_), static_cast<mode_t>(status.permissions()));
}

OutputFile::~OutputFile() {
  if (file_ != nullptr && file_ != stdout) std::fclose(file_);
  if (!temporary_.empty()) std::remove(temporary_.c_str());
}

void OutputFile::fail(int error_number) {
  if (error_number == EPIPE) throw BrokenPipe();
  throw IoError(path_ == "-" ? "standard output" : path_,
                fmt::format("cannot be written: {}", std::strerror(error_number)));
}

void OutputFile::write(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail(errno);
}

void OutputFile::commit() { commit(nullptr); }

void OutputFile::commit(const std::function<void()>& before_rename) {
  if (std::fflush(file_) != 0) fail(errno);
  if (file_ == stdout) {
    file_ = nullptr;
    return;
  }
  if (!temporary_.empty() && ::fsync(::fileno(file_)) != 0) fail(errno);
  std::FILE* closing = file_;
  file_ = nullptr;
  if (std::fclose(closing) != 0) fail(errno);
  if (temporary_.empty()) return;
  if (before_rename) before_rename();
  if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
  temporary_.clear();
}

void write_text(const std::string& path, std::string_view text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace leeway::io
