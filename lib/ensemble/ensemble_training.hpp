#pragma once

#include <functional>
#include <string>
#include <vector>

#include "ensemble/member_owner.hpp"
#include "ensemble/model_files.hpp"

namespace leeway::ensemble {

/// Which members to train into a folder, and how.
struct EnsembleTraining {
  std::string folder;
  std::vector<int> members;
  bool resume = false;                     ///< keep finished members, continue from checkpoints
  double checkpoint_interval_s = 30;       ///< 0: after every optimizer step
  std::size_t jobs = 1;                    ///< members at a time; each is one thread
  const TrainingData* held_out = nullptr;  ///< evaluated a hundred times on the way, and never trained on
  std::function<bool()> stop = nullptr;    ///< asked after every optimizer step; must be safe from several threads
};

/// What is called from the training threads, one at a time; empty: nothing.
struct TrainingReports {
  /// After each epoch of a member (and once with what a resumed member already has).
  std::function<void(int member, const MemberProgress&)> progress = nullptr;
  std::function<void(const std::string&)> warning = nullptr;
};

/// Trains the members and writes their files; equal members are equal bytes, whatever `jobs`, whether in one process or
/// several, and however often they were stopped. A checkpoint that cannot be written is a warning, and the one before
/// it stays. Returns false if `stop` asked for the end; what was in training then has a checkpoint. Throws IoError
/// where another process trains one of the members, and where a member or its last checkpoint cannot be written.
bool train_ensemble(const TrainingData& data, const EnsembleHeader& header, const EnsembleTraining& training,
                    const nn::Kernels<float>& kernels, const TrainingReports& reports);

}  // namespace leeway::ensemble
