#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "ensemble/member.hpp"

namespace leeway::ensemble {

/// Everything that decides how training goes on: a checkpoint. Random numbers are drawn from streams of their own for
/// each epoch, so there is no generator to save.
struct TrainingState {
  Member member;
  int epochs_done = 0;
  long adam_steps = 0;
  nn::AlignedVector<float> adam_m, adam_v;
};

/// A member before its first step: weights, moments, and the standardization of its outputs over 10,000 standard
/// normal inputs.
TrainingState initial_training_state(const TrainingData& data, std::uint64_t seed, int number,
                                     const nn::Kernels<float>& kernels);

/// Trains until the config's epochs are done; calls after_epoch(state) at the end of each. The result depends on the
/// data, the config, the seed and the kernel path alone. Throws NumericalError when the loss is no finite number.
void train(const TrainingData& data, std::uint64_t seed, const nn::Kernels<float>& kernels, TrainingState& state,
           const std::function<void(const TrainingState&)>& after_epoch);

}  // namespace leeway::ensemble
