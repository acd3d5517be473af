#pragma once

#include <functional>
#include <string>
#include <vector>

#include "ensemble/model_files.hpp"

namespace leeway::ensemble {

/// Which members to train into a folder, and how.
struct EnsembleTraining {
  std::string folder;
  std::vector<int> members;
  bool resume = false;                ///< keep finished members, go on from checkpoints
  double checkpoint_interval_s = 30;  ///< 0: after every epoch
  std::size_t jobs = 1;               ///< members at a time; each is one thread
};

/// Called from the training threads after each epoch of a member (and once with the epochs that a resumed member
/// already has). It must be safe to call from several threads.
using TrainingProgress = std::function<void(int member, int epochs_done, double loss)>;

/// Trains the members and writes their files; equal members are equal bytes, whatever `jobs`, and whether in one
/// process or several. Returns notices.
std::vector<std::string> train_ensemble(const TrainingData& data, const EnsembleHeader& header,
                                        const EnsembleTraining& training, const nn::Kernels<float>& kernels,
                                        const TrainingProgress& progress);

}  // namespace leeway::ensemble
