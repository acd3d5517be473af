#include "ensemble/training.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"

namespace leeway::ensemble {
namespace {

constexpr int kStandardizationInputs = 10000;

void standardize_outputs(Member& member, const nn::Kernels<float>& kernels, RandomStream& random) {
  const std::size_t width = static_cast<std::size_t>(member.dynamics.inputs);
  nn::AlignedVector<float> inputs(width * kStandardizationInputs), outputs(std::size_t{3} * kStandardizationInputs);
  for (float& x : inputs) x = static_cast<float>(random.normal());
  const nn::KernelWorkspace<float> workspace(kernels);
  const nn::PackedNetwork<float> network(kernels, member.dynamics, member.parameters.data());
  kernels.forward(workspace.get(), network.get(), inputs.data(), kStandardizationInputs, outputs.data());
  for (std::size_t i = 0; i < 3; ++i) {
    double mean = 0.0, square = 0.0;
    for (std::size_t n = 0; n < kStandardizationInputs; ++n) mean += outputs[3 * n + i] / kStandardizationInputs;
    for (std::size_t n = 0; n < kStandardizationInputs; ++n)
      square += (outputs[3 * n + i] - mean) * (outputs[3 * n + i] - mean) / kStandardizationInputs;
    member.output_mean[i] = mean;
    member.output_sd[i] = std::sqrt(square);
  }
}

double learning_rate(const TrainingConfig& config, double progress) {
  if (config.schedule == RateSchedule::constant) return config.learning_rate;
  return config.learning_rate * 0.5 * (1.0 + std::cos(kPi * progress));
}

void clip(nn::AlignedVector<float>& gradient, double largest_norm) {
  double square = 0.0;
  for (const float g : gradient) square += static_cast<double>(g) * g;
  const double norm = std::sqrt(square);
  if (norm <= largest_norm) return;
  const float factor = static_cast<float>(largest_norm / norm);
  for (float& g : gradient) g *= factor;
}

}  // namespace

TrainingState initial_training_state(const TrainingData& data, std::uint64_t seed, int number,
                                     const nn::Kernels<float>& kernels) {
  TrainingState state;
  Member& member = state.member;
  member.number = number;
  member.kernel = kernels.name;
  member.dynamics = dynamics_shape(data.inputs, data.config);
  member.initial_state = initial_state_shape(data.inputs, data.config);
  const auto index = static_cast<std::uint64_t>(number);
  RandomStream weights(seed, "initial weights", index), start(seed, "initial-state weights", index);
  member.parameters = nn::initial_parameters(member.dynamics, weights);
  const nn::AlignedVector<float> more = nn::initial_parameters(member.initial_state, start);
  member.parameters.insert(member.parameters.end(), more.begin(), more.end());
  RandomStream inputs(seed, "output standardisation", index);
  standardize_outputs(member, kernels, inputs);
  state.adam_m.assign(member.parameters.size(), 0.0F);
  state.adam_v.assign(member.parameters.size(), 0.0F);
  return state;
}

void train(const TrainingData& data, std::uint64_t seed, const nn::Kernels<float>& kernels, TrainingState& state,
           const std::function<void(const TrainingState&)>& after_epoch) {
  const TrainingConfig& config = data.config;
  Member& member = state.member;
  const RolloutConstants<float> constants(data.inputs, config, member);
  const nn::KernelWorkspace<float> workspace(kernels);
  WindowBatch<float> batch;
  nn::AlignedVector<float> gradient(member.parameters.size());
  std::vector<std::size_t> order(data.windows.size());
  const std::size_t batch_size = static_cast<std::size_t>(config.batch_size);

  while (state.epochs_done < config.epochs) {
    std::iota(order.begin(), order.end(), std::size_t{0});
    RandomStream random(seed, fmt::format("shuffle of member {}", member.number),
                        static_cast<std::uint64_t>(state.epochs_done));
    random.shuffle(order);
    double loss_sum = 0.0, points = 0.0;
    for (std::size_t begin = 0; begin < order.size(); begin += batch_size) {
      batch.assign(data, order.data() + begin, std::min(batch_size, order.size() - begin));
      const double loss = kernels.loss_and_gradient(workspace.get(), constants.view(), batch.view(),
                                                    member.parameters.data(), gradient.data());
      if (!std::isfinite(loss))
        throw NumericalError(
            fmt::format("member {}: the loss is no finite number in epoch {}: training diverged. Lower learning_rate "
                        "(now {}) or set gradient_clip_norm (now {})",
                        member.number, state.epochs_done + 1, config.learning_rate, config.gradient_clip_norm));
      if (config.gradient_clip_norm > 0.0) clip(gradient, config.gradient_clip_norm);
      nn::AdamSettings adam;
      adam.learning_rate = learning_rate(
          config, (state.epochs_done + static_cast<double>(begin) / static_cast<double>(order.size())) / config.epochs);
      kernels.adam(adam, ++state.adam_steps, gradient.size(), gradient.data(), member.parameters.data(),
                   state.adam_m.data(), state.adam_v.data());
      loss_sum += loss * batch.points();
      points += batch.points();
    }
    member.training_curve.push_back(static_cast<float>(loss_sum / points));
    ++state.epochs_done;
    after_epoch(state);
  }
}

}  // namespace leeway::ensemble
