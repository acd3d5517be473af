#include "io/files.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <memory>
#include <mutex>
#include <random>
#include <set>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>
#include <openssl/evp.h>

#include "core/errors.hpp"
#include "core/similar_words.hpp"

namespace leeway::io {
namespace fs = std::filesystem;
namespace {

std::string configs_folder() { return installed_file("share/leeway/configs"); }

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
  std::array<char, 1 << 16> buffer;  // filled by what is read alone
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

// Tells temporary files of this machine from those of others that share a folder.
const std::string& this_machine() {
  static const std::string hash = [] {
    std::array<char, 256> name{};
    ::gethostname(name.data(), name.size() - 1);
    return sha256(name.data()).substr(0, 8);
  }();
  return hash;
}

// The machine in the name of a temporary file, "<output>.<8 digits>-<8 digits>.tmp"; empty for other names.
std::string machine_of(const std::string& name) {
  constexpr std::size_t kDigits = 8, kLength = 2 * kDigits + 6;
  if (name.size() <= kLength || !name.ends_with(".tmp")) return "";
  const std::string tail = name.substr(name.size() - kLength);
  const auto is_hex = [](const std::string& text) {
    return text.find_first_not_of("0123456789abcdef") == std::string::npos;
  };
  const std::string machine = tail.substr(1, kDigits);
  const bool matches = tail[0] == '.' && tail[kDigits + 1] == '-' && is_hex(machine);
  return matches && is_hex(tail.substr(kDigits + 2, kDigits)) ? machine : "";
}

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

std::string installed_file(const std::string& name) {
  std::error_code error;
  const fs::path executable = fs::read_symlink("/proc/self/exe", error);
  return (executable.parent_path().parent_path() / name).string();
}

std::string stem(const std::string& path) {
  if (path == "-") return "stdin";
  const fs::path name(path);
  return (name.extension() == ".gz" ? name.stem().stem() : name.stem()).string();
}

std::string link_target(const std::string& path) {
  std::error_code error;
  std::string target = path;
  for (int links = 0; links < 40 && fs::is_symlink(target, error); ++links) {
    const fs::path next = fs::read_symlink(target, error);
    target = (fs::path(target).parent_path() / next).string();
  }
  return target;
}

void remove_leftovers(const std::string& folder) {
  static std::mutex mutex;
  static std::set<std::string> done;
  const std::lock_guard lock(mutex);
  if (!done.insert(folder).second) return;
  std::error_code error;
  std::vector<fs::path> leftovers;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, error)) {
    const std::string machine = machine_of(entry.path().filename().string());
    if (machine.empty() || !entry.is_regular_file(error)) continue;
    const auto age = fs::file_time_type::clock::now() - entry.last_write_time(error);
    if (machine == this_machine() || age > std::chrono::hours(24)) leftovers.push_back(entry.path());
  }
  for (const fs::path& path : leftovers) {
    const int fd = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0) continue;
    if (::flock(fd, LOCK_EX | LOCK_NB) == 0) fs::remove(path, error);
    ::close(fd);
  }
}

void remove_output(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  const bool is_there = fs::exists(status);
  if (path == "-" || (is_there && !fs::is_regular_file(status) && !fs::is_directory(status))) return;
  { const OutputFile attempt(path); }
  if (!is_there) return;
  fs::remove(link_target(path), error);
  if (error) throw IoError(path, fmt::format("cannot be removed: {}", error.message()));
}

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
  const std::vector<std::string> names = config_names(folder);
  throw UsageError(fmt::format("no file '{}', and no shipped configuration of that name in configs/{}; shipped: {}{}",
                               name_or_path, folder, fmt::join(names, ", "), did_you_mean(name_or_path, names)));
}

OutputFile::OutputFile(const std::string& path) : path_(path) {
  if (path.empty()) throw IoError("''", "is no name of an output");
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
  target_ = link_target(path);  // the temporary file lies beside it
  if (fs::exists(status) && ::access(target_.c_str(), W_OK) != 0) fail(errno);
  remove_leftovers(fs::path(target_).parent_path().string());
  open_temporary();
  if (fs::exists(status)) ::fchmod(::fileno(file_), static_cast<mode_t>(status.permissions()));
}

void OutputFile::open_temporary() {
  for (;;) {
    temporary_ = fmt::format("{}.{}-{:08x}.tmp", target_, this_machine(), std::random_device{}());
    const int fd = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0) {
      const int error_number = errno;
      temporary_.clear();
      fail(error_number);
    }
    // For remove_leftovers(), which holds it no longer than it takes to remove a file; some file systems have no locks.
    while (::flock(fd, LOCK_EX) != 0 && errno == EINTR) continue;
    struct stat status {};
    if (::fstat(fd, &status) == 0 && status.st_nlink == 0) {  // it came between, and took the file for a leftover
      ::close(fd);
      continue;
    }
    lock_ = ::dup(fd);
    file_ = ::fdopen(fd, "wb");
    if (file_ == nullptr) fail(errno);
    return;
  }
}

OutputFile::~OutputFile() {
  if (file_ != nullptr && file_ != stdout) std::fclose(file_);
  if (!temporary_.empty()) std::remove(temporary_.c_str());
  if (lock_ >= 0) ::close(lock_);
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
