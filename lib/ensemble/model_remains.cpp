#include <algorithm>
#include <charconv>
#include <filesystem>
#include <initializer_list>
#include <unistd.h>

#include <fmt/format.h>

#include "ensemble/member_owner.hpp"
#include "ensemble/model_files.hpp"
#include "io/files.hpp"
#include "io/outputs.hpp"

namespace leeway::ensemble {
namespace fs = std::filesystem;
namespace {

// The number in "member-NN...": nothing for a file of another name or ending.
std::optional<int> member_of(const std::string& path, const std::string& ending) {
  const std::string name = fs::path(path).filename().string(), prefix = "member-";
  if (!name.starts_with(prefix) || !name.ends_with(ending)) return std::nullopt;
  int number = 0;
  const char* const begin = name.data() + prefix.size();
  const auto [end, error] = std::from_chars(begin, name.data() + name.size(), number);
  if (error != std::errc() || end - begin < 2 || *end != '.') return std::nullopt;
  return number;
}

void remove_files(const std::string& folder, const std::string& prefix, std::initializer_list<const char*> endings) {
  std::error_code error;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const auto ends = [&](const char* ending) { return name.ends_with(ending); };
    if (name.starts_with(prefix) && std::any_of(endings.begin(), endings.end(), ends)) found.push_back(entry.path());
  }
  for (const fs::path& path : found) fs::remove(path, error);
}

}  // namespace

void require_room(const std::string& folder, const TrainingConfig& config) {
  constexpr double kBookkeeping_B = 500.0;  // of a member, in memory: names, progress, JSON
  const double members = config.members;
  const double memory_B = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  if (members * kBookkeeping_B > memory_B)
    throw NumericalError(
        fmt::format("out of memory: a list of {} members alone takes {:.3g} GB, and this machine has {:.3g}",
                    config.members, members * kBookkeeping_B / 1e9, memory_B / 1e9));
  // The networks see three velocities at the least, and a weight has four digits at the least, and a comma.
  const std::size_t weights = nn::parameter_count({3, config.hidden_layers, config.hidden_units, 3});
  const double disk_B = members * static_cast<double>(weights) * 5.0;
  std::error_code error;
  fs::path there = fs::absolute(folder, error);
  while (!fs::exists(there, error) && there.has_relative_path()) there = there.parent_path();
  const fs::space_info space = fs::space(there, error);
  if (!error && disk_B > static_cast<double>(space.capacity))  // what is full now may have room by then
    throw IoError(folder, fmt::format("{} members take {:.3g} GB at the least, and the disk has {:.3g}", config.members,
                                      disk_B / 1e9, static_cast<double>(space.capacity) / 1e9));
}

void refuse_owners(const std::string& folder) {
  for (const std::string& file : io::files_in(folder))
    if (const auto number = member_of(file, ".owner"))
      if (const auto owner = read_owner(folder, *number); owner && owner->alive())
        throw IoError(
            file,
            fmt::format("process {} of this machine trains this member; end it, or choose another folder", owner->pid));
}

void remove_training(const std::string& folder) {
  refuse_owners(folder);
  io::remove_output((fs::path(folder) / "ensemble.json").string());
  std::error_code error;
  fs::remove(calibration_path(folder), error);
  for (const std::string& file : io::files_in(folder))
    for (const char* ending : {".json", ".checkpoint", ".owner", ".tmp"})
      if (member_of(file, ending)) fs::remove(file, error);
}

void remove_unfinished(const std::string& folder, int number) {
  remove_files(folder, fmt::format("member-{:02}.", number), {".tmp"});
}

void remove_remains(const std::string& folder, int number) {
  remove_files(folder, fmt::format("member-{:02}.", number), {".checkpoint", ".owner", ".tmp"});
}

}  // namespace leeway::ensemble
