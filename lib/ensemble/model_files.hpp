#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ensemble/training.hpp"
#include "io/json.hpp"

namespace leeway::ensemble {

/// The base model of an ensemble; its ship lies beside ensemble.json.
struct BaseRecord {
  std::string name, sha256;        ///< of the ship, and of its file
  double spread = 0.0;             ///< of the members' own ships: TrainingData::base_spread
  std::string stated_sha256 = {};  ///< of the file of the ship that it was fitted from; empty where it was not

  friend bool operator==(const BaseRecord&, const BaseRecord&) = default;
};

/// What ensemble.json holds: all that decides the training of its members, and their number.
struct EnsembleHeader {
  TrainingConfig config;
  ModelInputs inputs;
  std::uint64_t seed = 1;
  std::vector<TrainingFile> files;
  std::optional<BaseRecord> base = std::nullopt;
  /// SHA-256 of all of the above but the number of members; each member file repeats it.
  std::string training_id;
  bool is_hashed = true;  ///< false where the files are of an earlier version, which has no hashes
};

EnsembleHeader make_header(const TrainingData& data, std::uint64_t seed, std::vector<TrainingFile> files);

/// <folder>/ensemble.json, and the ship of the base model, if there is one, in base_path().
///   base, stated  those of the header
void write_header(const std::string& folder, const EnsembleHeader& header, const io::Json& provenance,
                  const BaseModel* base = nullptr, const BaseModel* stated = nullptr);
/// Throws InputError or IoError; nothing where the file does not exist and `optional`.
std::optional<EnsembleHeader> read_header(const std::string& folder, bool optional = false);

/// Whether a path is that of a file that a training writes or removes in its folder.
bool is_model_file(const std::string& path);

/// <folder>/base-ship.json, and the ship that it was fitted from.
std::string base_path(const std::string& folder);
std::string stated_path(const std::string& folder);
/// Whether these files are the header's; also where there is no base.
bool has_base_file(const std::string& folder, const EnsembleHeader& header);
/// The base model of the ensemble in the folder, or nothing. Throws InputError where the file is not the one that the
/// members were trained with.
std::shared_ptr<const BaseModel> read_base(const std::string& folder, const EnsembleHeader& header);
/// The ship that was given to the training, before any fit, or nothing. Throws as read_base().
std::shared_ptr<const BaseModel> read_given_base(const std::string& folder, const EnsembleHeader& header);
/// The member's own ship, or nothing. Throws as read_base().
std::shared_ptr<const BaseModel> read_own_base(const std::string& folder, const Member& member);

/// <folder>/member-NN.json, the ship that the member learned on where it has one of its own, and its checkpoint.
std::string member_path(const std::string& folder, int number);
std::string member_ship_path(const std::string& folder, int number);
std::string checkpoint_path(const std::string& folder, int number);
/// <folder>/calibration.json (calibration.hpp).
std::string calibration_path(const std::string& folder);

///   before_rename  as for io::OutputFile::commit()
void write_member(const std::string& folder, const Member& member, const EnsembleHeader& header,
                  const std::function<void()>& before_rename = nullptr);
/// Throws InputError where the file belongs to another training.
Member read_member(const std::string& folder, int number, const EnsembleHeader& header);
bool member_exists(const std::string& folder, int number);

/// Checkpoints hold the same numbers as the running training, bit for bit, and a hash over all of them. A finished
/// member replaces its checkpoint.
void write_checkpoint(const std::string& folder, const TrainingState& state, const EnsembleHeader& header,
                      const std::function<void()>& before_rename = nullptr);
std::optional<TrainingState> read_checkpoint(const std::string& folder, int number, const EnsembleHeader& header);
void remove_checkpoint(const std::string& folder, int number);

/// Throws NumericalError or IoError where the members' number is beyond this machine's memory or the whole of the
/// folder's disk.
void require_room(const std::string& folder, const TrainingConfig& config);

/// Throws IoError where a process of this machine trains a member in the folder.
void refuse_owners(const std::string& folder);

/// Removes an earlier training, also what is left of one: ensemble.json first, then members and checkpoints. Throws
/// IoError where a process of this machine trains one of them.
void remove_training(const std::string& folder);
/// Removes what a killed training left of a member's files half written.
void remove_unfinished(const std::string& folder, int number);
/// Removes what a kill just after the end of a training left beside the finished member.
void remove_remains(const std::string& folder, int number);

}  // namespace leeway::ensemble
