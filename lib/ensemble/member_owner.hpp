#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "core/errors.hpp"

namespace leeway::ensemble {

/// How far the training of a member is.
struct MemberProgress {
  int epochs_done = 0;
  std::optional<double> loss;           ///< training loss of the last whole epoch
  std::optional<double> held_out_loss;  ///< the last one that was evaluated
  std::optional<double> seconds_left;
};

/// <folder>/member-NN.owner: the process that trains a member, and its progress. The file lies there while the member
/// is in training, and after a kill.
struct OwnerRecord {
  std::string host;
  long pid = 0;
  std::uint64_t process_start = 0;  ///< clock ticks from the start of the machine, which distinguish reused numbers
  std::string token;                ///< random
  MemberProgress progress;
  double age_s = 0.0;  ///< since it was written, by the clock of the file system

  bool here() const;   ///< whether the process is or was one of this machine
  bool alive() const;  ///< here, and the process has not ended
};

std::string owner_path(const std::string& folder, int number);
/// Nothing where there is no record, or none that can be understood.
std::optional<OwnerRecord> read_owner(const std::string& folder, int number);

/// Another process has taken the member.
struct Displaced : IoError {
  using IoError::IoError;
};

/// One process per member, without locks, which not every shared file system has. A process takes a member by putting a
/// record with a random token in its place. Before it renames anything into place it looks whether its token still
/// stands there, and stops if not: of two the later one stays. No file is ever torn; and as two trainings of a member
/// are equal to the last bit, a file that slips through between look and rename does no harm. Should that be the record
/// itself, it is the other process that finds another token.
class MemberOwner {
 public:
  /// Takes the member. Throws IoError where a process of this machine trains it; one of another machine is displaced.
  MemberOwner(const std::string& folder, int number);
  ~MemberOwner();  ///< removes the record unless another process has replaced it
  MemberOwner(const MemberOwner&) = delete;
  MemberOwner& operator=(const MemberOwner&) = delete;

  /// Throws Displaced if another process has taken the member.
  void check() const;
  /// Writes the record anew, with check().
  void report(const MemberProgress& progress);

 private:
  void write(const std::function<void()>& before_rename) const;

  std::string folder_;
  int number_;
  OwnerRecord record_;
};

/// Keeps a training that begins anew from others of this machine in its folder, as far as the file system has locks:
/// it is alone while it clears the folder and writes ensemble.json, and shares the folder from then on.
class TrainingLock {
 public:
  explicit TrainingLock(const std::string& folder);
  ~TrainingLock();
  TrainingLock(const TrainingLock&) = delete;
  TrainingLock& operator=(const TrainingLock&) = delete;

  /// False where others train in the folder.
  bool is_alone() const;
  /// Waits while another one clears the folder.
  void share() const;

 private:
  int fd_;
};

}  // namespace leeway::ensemble
