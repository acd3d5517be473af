#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ensemble/member_owner.hpp"

namespace leeway::ensemble {

enum class MemberState {
  waiting,      ///< nothing of it is there
  training,     ///< a process says so: one of this machine that lives, or one elsewhere
  interrupted,  ///< begun, and no process is at it: --resume continues
  trained
};

struct MemberStatus {
  int number = 0;
  MemberState state = MemberState::waiting;
  MemberProgress progress;
  std::optional<OwnerRecord> owner;  ///< of a member in training
};

struct TrainingStatus {
  int epochs = 0;
  std::vector<MemberStatus> members;
};

/// The state of a training from its folder alone, while it runs and after. Throws as read_header().
TrainingStatus read_training_status(const std::string& folder);

}  // namespace leeway::ensemble
