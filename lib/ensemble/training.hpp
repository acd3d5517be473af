#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "ensemble/member.hpp"

namespace leeway::ensemble {

/// Everything that decides how training continues, after any optimizer step: a checkpoint. Random numbers are drawn
/// from streams of their own for each epoch, so there is no generator to save: the order of an epoch's windows follows
/// from its number.
struct TrainingState {
  Member member;
  int epochs_done = 0;
  std::size_t windows_done = 0;         ///< of the epoch under way
  double loss_sum = 0.0, points = 0.0;  ///< over these windows
  long adam_steps = 0;
  nn::AlignedVector<float> adam_m, adam_v;
  nn::AlignedVector<float> muon_momentum;  ///< empty without Muon
};

/// What a member keeps of the ship that it learns on: nothing where that is the ship of the whole ensemble.
///   data  as the member sees them
std::optional<OwnBase> own_base_of(const TrainingData& data);

/// A member before its first step: weights, moments, and the standardization of its outputs over 10,000 standard
/// normal inputs.
TrainingState initial_training_state(const TrainingData& data, std::uint64_t seed, int number,
                                     const nn::Kernels<float>& kernels);

/// Bounds the Euclidean norm of a gradient, and keeps its direction.
void clip(nn::AlignedVector<float>& gradient, double largest_norm);

/// Trains until the config's epochs are done, or until after_step(state), called after each optimizer step, returns
/// false. Returns whether all epochs are done. The result depends on the data, the config, the seed and the kernel path
/// alone, however often training stops and continues. Throws NumericalError when the loss is no finite number.
bool train(const TrainingData& data, std::uint64_t seed, const nn::Kernels<float>& kernels, TrainingState& state,
           const std::function<bool(const TrainingState&)>& after_step);

/// The loss of a member over all windows of data that need not be those it was trained on.
///   base  its own ship, in place of that of the data; nothing: that of the data
double mean_loss(const TrainingData& data, const Member& member, const nn::Kernels<float>& kernels,
                 const BaseModel* base = nullptr);

}  // namespace leeway::ensemble
