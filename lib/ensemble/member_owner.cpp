#include "ensemble/member_owner.hpp"

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <fcntl.h>
#include <filesystem>
#include <limits>
#include <random>
#include <sstream>
#include <sys/file.h>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/files.hpp"
#include "io/json.hpp"

namespace leeway::ensemble {
namespace fs = std::filesystem;
namespace {

std::string host_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "unknown";
  return name.data();
}

// When a process began; nothing where it has ended, also where its parent has not yet taken note of that.
std::optional<std::uint64_t> start_of_process(long pid) {
  std::string stat;
  try {
    stat = io::read_text(fmt::format("/proc/{}/stat", pid));
  } catch (const IoError&) {
    return std::nullopt;
  }
  // The name, in parentheses, may hold blanks: fields count from behind it. The first is the state, the 20th the start.
  std::istringstream fields(stat.substr(std::min(stat.size(), stat.rfind(')') + 1)));
  std::string field;
  std::uint64_t start = 0;
  fields >> field;
  if (field.empty() || field == "Z" || field == "X") return std::nullopt;
  for (int i = 2; i < 20; ++i) fields >> field;
  return fields >> start ? std::optional(start) : std::nullopt;
}

io::Json number_or_null(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? io::Json(*value) : io::Json();
}

std::optional<double> number_from(const io::Json& value) {
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

std::string process_of(const OwnerRecord& record) {
  return fmt::format("process {} {}", record.pid, record.here() ? "of this machine" : "on " + record.host);
}

}  // namespace

bool OwnerRecord::here() const { return host == host_name(); }

bool OwnerRecord::alive() const { return here() && start_of_process(pid) == process_start; }

std::string owner_path(const std::string& folder, int number) {
  return (fs::path(folder) / fmt::format("member-{:02}.owner", number)).string();
}

std::optional<OwnerRecord> read_owner(const std::string& folder, int number) {
  const std::string path = owner_path(folder, number);
  try {
    const io::Json json = io::parse_json(io::read_text(path), path);
    const io::JsonObject object(json, path);
    OwnerRecord record;
    record.host = object.text("host");
    record.pid = object.integer("pid", io::kNotNegative);
    record.process_start = static_cast<std::uint64_t>(object.integer("process_start", io::kNotNegative));
    record.token = object.text("token");
    const io::Bounds epochs{0.0, std::numeric_limits<int>::max()};
    record.progress = {static_cast<int>(object.integer("epochs_done", epochs)), number_from(object.value("loss")),
                       number_from(object.value("held_out_loss")), number_from(object.value("seconds_left"))};
    std::error_code error;
    const auto written = fs::last_write_time(path, error);
    if (!error) record.age_s = std::chrono::duration<double>(fs::file_time_type::clock::now() - written).count();
    return record;
  } catch (const IoError&) {
  } catch (const InputError&) {
  } catch (const nlohmann::json::exception&) {
  }
  return std::nullopt;
}

MemberOwner::MemberOwner(const std::string& folder, int number) : folder_(folder), number_(number) {
  if (const auto other = read_owner(folder, number); other && other->alive())
    throw IoError(owner_path(folder, number), fmt::format("{} trains this member; wait for it, or end it and continue "
                                                          "with --resume",
                                                          process_of(*other)));
  std::random_device random;
  record_.host = host_name();
  record_.pid = ::getpid();
  record_.process_start = start_of_process(record_.pid).value_or(0);
  record_.token = fmt::format("{:08x}{:08x}", random(), random());
  write(nullptr);
}

MemberOwner::~MemberOwner() {
  const auto now = read_owner(folder_, number_);
  if (!now || now->token != record_.token) return;
  std::error_code error;
  fs::remove(owner_path(folder_, number_), error);
}

void MemberOwner::check() const {
  const auto now = read_owner(folder_, number_);
  if (now && now->token == record_.token) return;
  throw Displaced(owner_path(folder_, number_),
                  now ? fmt::format("{} has taken this member over; this process stops training it", process_of(*now))
                      : "has been removed: this process stops training the member");
}

void MemberOwner::report(const MemberProgress& progress) {
  record_.progress = progress;
  write([this] { check(); });
}

void MemberOwner::write(const std::function<void()>& before_rename) const {
  const MemberProgress& progress = record_.progress;
  const io::Json json{{"host", record_.host},
                      {"pid", record_.pid},
                      {"process_start", record_.process_start},
                      {"token", record_.token},
                      {"epochs_done", progress.epochs_done},
                      {"loss", number_or_null(progress.loss)},
                      {"held_out_loss", number_or_null(progress.held_out_loss)},
                      {"seconds_left", number_or_null(progress.seconds_left)}};
  io::OutputFile file(owner_path(folder_, number_));
  file.write(json.dump() + "\n");
  file.commit(before_rename);
}

TrainingLock::TrainingLock(const std::string& folder)
    : fd_(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {}

TrainingLock::~TrainingLock() {
  if (fd_ >= 0) ::close(fd_);
}

bool TrainingLock::is_alone() const { return fd_ < 0 || ::flock(fd_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK; }

void TrainingLock::share() const {
  while (fd_ >= 0 && ::flock(fd_, LOCK_SH) != 0 && errno == EINTR) continue;
}

}  // namespace leeway::ensemble
