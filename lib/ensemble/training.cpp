#include "ensemble/training.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "ensemble/muon.hpp"

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

// A number that a single-precision file holds: neither NaN nor infinite.
bool is_storable(double x) { return std::abs(x) <= std::numeric_limits<float>::max(); }

NumericalError diverged(const Member& member, int epoch, const TrainingConfig& config, const char* what) {
  return NumericalError(
      fmt::format("member {}: {} no finite number in epoch {}: training diverged. Lower learning_rate (now {}) or set "
                  "gradient_clip_norm (now {})",
                  member.number, what, epoch + 1, config.learning_rate, config.gradient_clip_norm));
}

}  // namespace

std::optional<OwnBase> own_base_of(const TrainingData& data) {
  if (!data.has_drawn_base) return std::nullopt;
  OwnBase own{data.base->sha256(), {}, {}};
  for (std::size_t i = 0; i < 3; ++i) {
    own.acceleration_mean[i] = data.inputs.accelerations[i].mean;
    own.acceleration_sd[i] = data.inputs.accelerations[i].sd;
  }
  return own;
}

TrainingState initial_training_state(const TrainingData& data, std::uint64_t seed, int number,
                                     const nn::Kernels<float>& kernels) {
  TrainingState state;
  Member& member = state.member;
  member.number = number;
  member.kernel = kernels.name;
  member.dynamics = dynamics_shape(data.inputs, data.config);
  member.initial_state = initial_state_shape(data.inputs, data.config);
  member.own_base = own_base_of(data);
  const auto index = static_cast<std::uint64_t>(number);
  RandomStream weights(seed, "initial weights", index), start(seed, "initial-state weights", index);
  member.parameters = nn::initial_parameters(member.dynamics, weights);
  const nn::AlignedVector<float> more = nn::initial_parameters(member.initial_state, start);
  member.parameters.insert(member.parameters.end(), more.begin(), more.end());
  RandomStream inputs(seed, "output standardisation", index);
  standardize_outputs(member, kernels, inputs);
  state.adam_m.assign(member.parameters.size(), 0.0F);
  state.adam_v.assign(member.parameters.size(), 0.0F);
  if (data.config.optimizer == Optimizer::muon)
    state.muon_momentum.assign(Muon({member.dynamics, member.initial_state}).size(), 0.0F);
  return state;
}

void clip(nn::AlignedVector<float>& gradient, double largest_norm) {
  double square = 0.0;
  for (const float g : gradient) square += static_cast<double>(g) * g;
  const double norm = std::sqrt(square);
  if (norm <= largest_norm) return;
  const float factor = static_cast<float>(largest_norm / norm);
  for (float& g : gradient) g *= factor;
}

bool train(const TrainingData& data, std::uint64_t seed, const nn::Kernels<float>& kernels, TrainingState& state,
           const std::function<bool(const TrainingState&)>& after_step) {
  const TrainingConfig& config = data.config;
  Member& member = state.member;
  const RolloutConstants<float> constants(data.inputs, config, member);
  const nn::KernelWorkspace<float> workspace(kernels);
  WindowBatch<float> batch;
  nn::AlignedVector<float> gradient(member.parameters.size());
  const std::size_t batch_size = static_cast<std::size_t>(config.batch_size);
  const Muon muon({member.dynamics, member.initial_state});

  while (state.epochs_done < config.epochs) {
    const int epoch = state.epochs_done;
    const std::vector<Window>& windows = data.windows_of_epoch(epoch);
    std::vector<std::size_t> order(windows.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    RandomStream random(seed, fmt::format("shuffle of member {}", member.number), static_cast<std::uint64_t>(epoch));
    random.shuffle(order);
    while (state.epochs_done == epoch) {
      const std::size_t begin = state.windows_done;
      batch.assign(data, windows, order.data() + begin, std::min(batch_size, order.size() - begin));
      const double loss = kernels.loss_and_gradient(workspace.get(), constants.view(), batch.view(),
                                                    member.parameters.data(), gradient.data());
      if (!is_storable(loss)) throw diverged(member, epoch, config, "the loss is");
      if (config.gradient_clip_norm > 0.0) clip(gradient, config.gradient_clip_norm);
      nn::AdamSettings adam;
      adam.learning_rate = learning_rate(
          config, (epoch + static_cast<double>(begin) / static_cast<double>(order.size())) / config.epochs);
      if (config.optimizer == Optimizer::muon)
        muon.step(config.muon_rate_factor * adam.learning_rate, gradient, member.parameters, state.muon_momentum);
      kernels.adam(adam, ++state.adam_steps, gradient.size(), gradient.data(), member.parameters.data(),
                   state.adam_m.data(), state.adam_v.data());
      if (!std::all_of(member.parameters.begin(), member.parameters.end(), is_storable))
        throw diverged(member, epoch, config, "the loss is");  // that of the next step
      state.loss_sum += loss * batch.points();
      state.points += batch.points();
      state.windows_done += batch_size;
      if (state.windows_done >= order.size()) {
        member.training_curve.push_back(static_cast<float>(state.loss_sum / state.points));
        ++state.epochs_done;
        state.windows_done = 0;
        state.loss_sum = state.points = 0.0;
        // No further step looks at what the last one made.
        if (state.epochs_done == config.epochs &&
            !is_storable(kernels.loss_and_gradient(workspace.get(), constants.view(), batch.view(),
                                                   member.parameters.data(), gradient.data())))
          throw diverged(member, epoch, config, "the loss after the last step is");
      }
      if (!after_step(state)) return state.epochs_done == config.epochs;
    }
  }
  return true;
}

double mean_loss(const TrainingData& data, const Member& member, const nn::Kernels<float>& kernels,
                 const BaseModel* base) {
  const RolloutConstants<float> constants(data.inputs, data.config, member);
  const nn::KernelWorkspace<float> workspace(kernels);
  WindowBatch<float> batch;
  nn::AlignedVector<float> gradient(member.parameters.size());  // which nobody needs
  std::vector<std::size_t> windows(data.windows.size());
  std::iota(windows.begin(), windows.end(), std::size_t{0});
  const std::size_t batch_size = static_cast<std::size_t>(data.config.batch_size);
  double sum = 0.0, points = 0.0;
  for (std::size_t begin = 0; begin < windows.size(); begin += batch_size) {
    batch.assign(data, data.windows, windows.data() + begin, std::min(batch_size, windows.size() - begin), base);
    sum += batch.points() * kernels.loss_and_gradient(workspace.get(), constants.view(), batch.view(),
                                                      member.parameters.data(), gradient.data());
    points += batch.points();
  }
  return sum / points;
}

}  // namespace leeway::ensemble
