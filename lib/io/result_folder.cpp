#include "io/result_folder.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <sys/file.h>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "io/files.hpp"

namespace leeway::io {
namespace fs = std::filesystem;
namespace {

constexpr const char* kUnfinished = ".unfinished";

// A name from a file that anybody may have written: only what lies below the folder counts.
bool lies_below(const std::string& name) {
  const fs::path path(name);
  return !name.empty() && path.is_relative() && std::find(path.begin(), path.end(), "..") == path.end();
}

bool is_regular(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

// What has been removed or renamed in a folder is so on the disk as well, before anything else is.
void flush_folder(const fs::path& folder) {
  const int fd = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

// Held while a run looks for others and says that it is there.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder)
      : fd_(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    while (fd_ >= 0 && ::flock(fd_, LOCK_EX) != 0 && errno == EINTR) continue;
  }
  ~FolderLock() {
    if (fd_ >= 0) ::close(fd_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int fd_;
};

std::map<std::string, std::string> hashes_from(const Json& json, const char* key) {
  std::map<std::string, std::string> hashes;
  if (json.contains(key) && json[key].is_object())
    for (const auto& [name, hash] : json[key].items())
      if (lies_below(name)) hashes[name] = hash.is_string() ? hash.get<std::string>() : "";
  return hashes;
}

}  // namespace

ResultFolder::ResultFolder(const std::string& folder, const std::string& index, const std::vector<std::string>& parts,
                           const std::string& generation)
    : folder_(folder),
      index_(path(index)),
      unfinished_(index_ + kUnfinished),
      planned_(parts.begin(), parts.end()),
      generation_(generation.empty() ? "" : sha256(generation)) {
  if (folder == "-")
    throw UsageError("expected a folder for the results, found '-': several files have no standard output");
  // The index names its parts in JSON.
  for (const std::string& name : parts) try {
      static_cast<void>(Json(name).dump());
    } catch (const Json::exception&) {
      throw UsageError(fmt::format("'{}': a result cannot have this name, since it is not UTF-8; rename the recording",
                                   Json(name).dump(-1, ' ', true, Json::error_handler_t::replace)));
    }
}

ResultFolder::~ResultFolder() {
  if (lock_ >= 0) ::close(lock_);
  if (!begun_ || committed_) return;
  std::error_code error;
  try {
    if (!is_as_before()) {
      const auto before = index_before_.empty() ? std::map<std::string, std::string>()
                                                : hashes_from(parse_json(index_before_, index_), "parts");
      for (const std::string& name : planned_)  // what has been written, and what it was to replace
        if (!parts_[name].empty() || before.contains(name)) fs::remove(path(name), error);
    }
    restore_index();
    fs::remove(unfinished_, error);
  } catch (const std::exception&) {  // the list of the unfinished run stays
  }
}

// Whether all that the index of an earlier run of this generation names is there, be it written anew.
bool ResultFolder::is_as_before() const {
  if (index_before_.empty()) return false;
  for (const auto& [name, hash] : hashes_from(parse_json(index_before_, index_), "parts"))
    if (!is_regular(path(name)) || sha256_of_file(path(name)) != hash) return false;
  return true;
}

// The index of files that stand beside those of this run, without those that this run has replaced.
void ResultFolder::restore_index() const {
  if (index_before_.empty()) return;
  Json index = parse_json(index_before_, index_);
  for (const auto& [name, hash] : hashes_from(index, "parts"))
    if (!is_regular(path(name)) || sha256_of_file(path(name)) != hash) index["parts"].erase(name);
  if (!index["parts"].empty()) write_text(index_, to_text(index));
}

// Throws IoError where a run that lives writes the folder and its files are not of this generation.
void ResultFolder::refuse_other_run() const {
  const int fd = ::open(unfinished_.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return;
  const bool lives = ::flock(fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(fd);
  const auto listing = lives ? read_listing(unfinished_) : std::nullopt;
  if (listing && (generation_.empty() || listing->generation != generation_))
    throw IoError(unfinished_, "another run is writing this folder; wait until it is done");
}

void ResultFolder::write_unfinished(const Json& listing) {
  write_text(unfinished_, to_text(listing));
  lock_ = ::open(unfinished_.c_str(), O_RDONLY | O_CLOEXEC);
  if (lock_ >= 0) ::flock(lock_, LOCK_EX | LOCK_NB);
}

std::string ResultFolder::path(const std::string& part) const { return (fs::path(folder_) / part).string(); }

// Nothing where there is no such file, or none of ours.
std::optional<ResultFolder::Listing> ResultFolder::read_listing(const std::string& file) const {
  if (!is_regular(file)) return std::nullopt;
  try {
    std::string text = read_text(file);
    const Json json = parse_json(text, file);
    if (!json.is_object()) return std::nullopt;
    const Json generation = json.value("generation", Json(""));
    return Listing{hashes_from(json, "parts"), hashes_from(json, "replaced"),
                   generation.is_string() ? generation.get<std::string>() : "", std::move(text)};
  } catch (const IoError&) {
  } catch (const InputError&) {
  }
  return std::nullopt;
}

std::vector<std::string> ResultFolder::outputs() const {
  std::set<std::string> names = planned_;
  for (const std::string& file : {index_, unfinished_})
    if (const auto listing = read_listing(file))
      for (const auto& parts : {listing->parts, listing->replaced})
        for (const auto& [name, hash] : parts)
          if (is_regular(path(name))) names.insert(name);
  std::vector<std::string> paths{index_};
  for (const std::string& name : names) paths.push_back(path(name));
  return paths;
}

// Files of the same generation that other runs have written, or are writing.
void ResultFolder::take_over(const Listing& listing) {
  for (const auto& [name, hash] : listing.parts) {
    if (planned_.contains(name)) continue;
    const std::string now = is_regular(path(name)) ? sha256_of_file(path(name)) : "";
    if (hash.empty() || now == hash) parts_[name] = now;
  }
}

void ResultFolder::remove(const std::map<std::string, std::string>& parts) const {
  std::set<fs::path> folders;
  std::error_code error;
  for (const auto& [name, hash] : parts) {
    const std::string file = path(name);
    folders.insert(fs::path(file).parent_path());
    if (is_regular(file) && (hash.empty() || sha256_of_file(file) == hash)) fs::remove(file, error);
  }
  const fs::path top = fs::path(index_).parent_path();
  for (auto folder = folders.rbegin(); folder != folders.rend(); ++folder) {  // those below others first
    remove_leftovers(folder->string());
    if (*folder != top) fs::remove(*folder, error);  // which fails unless it is empty
  }
}

void ResultFolder::begin() {
  make_directories(folder_);
  const FolderLock one_at_a_time(fs::path(index_).parent_path());
  refuse_other_run();
  std::map<std::string, std::string> replaced;
  for (const std::string& file : {unfinished_, index_}) {
    const auto listing = read_listing(file);
    if (!listing) continue;
    replaced.insert(listing->replaced.begin(), listing->replaced.end());
    if (generation_.empty() || listing->generation != generation_) {
      replaced.insert(listing->parts.begin(), listing->parts.end());
    } else {
      take_over(*listing);
      if (file == index_) index_before_ = listing->text;
    }
  }
  for (const auto& [name, hash] : parts_) replaced.erase(name);
  for (const std::string& name : planned_) parts_[name] = "";
  write_unfinished({{"generation", generation_}, {"parts", Json(parts_)}, {"replaced", Json(replaced)}});
  begun_ = true;
  std::error_code error;
  fs::remove(link_target(index_), error);
  if (error) throw IoError(index_, fmt::format("cannot be removed: {}", error.message()));
  flush_folder(fs::path(index_).parent_path());
  remove(replaced);
}

void ResultFolder::write(const std::string& part, std::string_view text) {
  write_text(path(part), text);
  const std::lock_guard lock(mutex_);
  parts_[part] = sha256(text);
}

void ResultFolder::add(const std::string& part) {
  std::string hash = sha256_of_file(path(part));
  const std::lock_guard lock(mutex_);
  parts_[part] = std::move(hash);
}

void ResultFolder::commit(Json index) {
  if (!generation_.empty()) {
    for (const std::string& file : {unfinished_, index_})  // of runs that went on beside this one
      if (const auto listing = read_listing(file); listing && listing->generation == generation_) take_over(*listing);
    index["generation"] = generation_;
  }
  index["parts"] = Json::object();
  for (const auto& [name, hash] : parts_)
    if (!hash.empty()) index["parts"][name] = hash;
  flush_folder(fs::path(index_).parent_path());
  write_text(index_, to_text(index));
  committed_ = true;
  std::error_code error;
  fs::remove(unfinished_, error);
  if (error) throw IoError(unfinished_, fmt::format("cannot be removed: {}", error.message()));
}

std::map<std::string, std::string> parts_of(const JsonObject& index) {
  std::map<std::string, std::string> parts;
  if (const auto object = index.object_if("parts"))
    for (const std::string& name : object->keys()) parts[name] = object->text(name);
  return parts;
}

void require_finished(const std::string& index_path) {
  std::error_code error;
  if (fs::exists(index_path + kUnfinished, error))
    throw InputError(index_path + kUnfinished,
                     "the run that writes this folder is not done, or was killed; wait, or run it again");
}

void require_unchanged(const std::string& path, const std::string& sha256, const std::string& index_path) {
  if (is_regular(path) && sha256_of_file(path) != sha256)
    throw InputError(path, fmt::format("is not the file that {} names: its SHA-256 differs from that in /parts. Was it "
                                       "edited, or written over by another run?",
                                       index_path));
}

}  // namespace leeway::io
