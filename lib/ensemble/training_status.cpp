#include "ensemble/training_status.hpp"

#include "ensemble/model_files.hpp"

namespace leeway::ensemble {
namespace {

MemberStatus look_at(const std::string& folder, int number, const EnsembleHeader& header) {
  MemberStatus status;
  status.number = number;
  if (member_exists(folder, number)) {
    status.state = MemberState::trained;
    status.progress = {header.config.epochs, read_member(folder, number, header).training_curve.back(), std::nullopt,
                       std::nullopt};
  } else if (const auto owner = read_owner(folder, number); owner && (owner->alive() || !owner->here())) {
    status.state = MemberState::training;
    status.progress = owner->progress;
    status.owner = owner;
  } else if (const auto checkpoint = read_checkpoint(folder, number, header)) {
    status.state = MemberState::interrupted;
    status.progress.epochs_done = checkpoint->epochs_done;
    if (!checkpoint->member.training_curve.empty()) status.progress.loss = checkpoint->member.training_curve.back();
  }
  return status;
}

}  // namespace

TrainingStatus read_training_status(const std::string& folder) {
  const EnsembleHeader header = *read_header(folder);
  TrainingStatus status{header.config.epochs, {}};
  for (int number = 0; number < header.config.members; ++number) {
    try {
      status.members.push_back(look_at(folder, number, header));
    } catch (const IoError&) {  // a file has made way for its successor between two looks
      status.members.push_back(look_at(folder, number, header));
    }
  }
  return status;
}

}  // namespace leeway::ensemble
