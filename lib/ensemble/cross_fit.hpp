#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "ensemble/calibration.hpp"

namespace leeway::ensemble {

struct CrossFitting {
  const std::vector<Trajectory>& recordings;
  const TrainingConfig& config;
  std::shared_ptr<const BaseModel> base;    ///< as given to the training: nothing, or the ship before any fit
  std::shared_ptr<const BaseModel> fitted;  ///< to all recordings, where the folds' fits start; nothing: at the base
  std::uint64_t seed = 1;
  std::size_t jobs = 1;
  const nn::Kernels<float>& kernels;
  std::function<bool()> stop;      ///< nothing: never
  std::function<void()> progress;  ///< called as each network is trained, one call at a time; nothing: nobody listens
};

/// Finds what held-out predictions miss. The recordings are dealt to folds; networks that are trained as the
/// ensemble's, on the recordings of all other folds, predict those of a fold in sequences from their recorded states.
/// What they miss beyond their own spread is given to the noises of error_growth.hpp, which spread through the
/// networks' own derivatives.
///
/// Radii: the k-th smallest of n recordings' largest errors, k = ceil((n + 1) share), which a further recording that is
/// exchangeable with these exceeds with probability 1 - share at most, if its networks are as those of the folds.
///
/// Returns nothing where it is stopped. Throws InputError for fewer than two recordings that hold a sequence.
std::optional<Calibration> cross_fit(const CrossFitting& fitting);

/// Throws InputError where a calibration that is asked for has no recordings to hold out in turn: fewer than two.
void require_recordings_to_hold_out(const TrainingConfig& config, const std::vector<Trajectory>& recordings);

/// Networks that cross_fit() trains for so many recordings.
int networks_of_cross_fit(const TrainingConfig& config, std::size_t recordings);

}  // namespace leeway::ensemble
