#include "ensemble/residual_training.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/parallel.hpp"
#include "ensemble/training.hpp"

namespace leeway::ensemble {
namespace {

constexpr int kMembers = 3, kUnits = 16, kMostEpochs = 400, kFewestEpochs = 20;
constexpr double kPoints = 240e3;  // that a member sees altogether, each as often as there are epochs

TrainingConfig config_of(const ResidualTraining& training) {
  TrainingConfig config;
  config.time_step_s = training.time_step_s;
  config.steps = 30;
  config.initial_state_steps = 10;
  config.hidden_layers = 1;
  config.hidden_units = kUnits;
  config.sigma = training.sigma;
  config.learning_rate = 1e-2;
  config.schedule = RateSchedule::cosine;
  config.gradient_clip_norm = 1000.0;
  config.batch_size = 8;
  config.epochs = kMostEpochs;
  config.members = kMembers;
  return config;
}

// A member's layer as it stands in its parameters; returns what follows.
const float* read(const float* from, Eigen::Index rows, Eigen::Index columns, ResidualNetwork::Layer& layer) {
  layer.weights = Eigen::Map<const Eigen::MatrixXf>(from, rows, columns).cast<double>();
  from += rows * columns;
  layer.biases = Eigen::Map<const Eigen::VectorXf>(from, rows).cast<double>();
  return from + rows;
}

}  // namespace

std::shared_ptr<const ResidualNetwork> learn_residual(const Ship& ship, const std::vector<Trajectory>& recordings,
                                                      const ResidualTraining& training) {
  TrainingData data =
      prepare_training_data(recordings, config_of(training), std::make_shared<const BaseModel>(ship, std::string()));
  double points = 0.0;
  for (const Window& window : data.windows) points += static_cast<double>(window.range.size);
  data.config.epochs = std::clamp(static_cast<int>(kPoints / points), kFewestEpochs, kMostEpochs);

  std::vector<Member> members(kMembers);
  const nn::Kernels<float>& kernels = nn::kernels();
  parallel_for(members.size(), training.jobs, [&](std::size_t i) {
    TrainingState state = initial_training_state(data, training.seed, static_cast<int>(i), kernels);
    train(data, training.seed, kernels, state, [](const TrainingState&) { return true; });
    members[i] = std::move(state.member);
  });

  // Side by side, the members are one network whose outputs are their mean.
  ResidualNetwork network;
  for (std::size_t i = 0; i < data.inputs.inputs.size(); ++i) {
    const Spread& spread = data.inputs.inputs[i];
    const InputRange& range = data.inputs.domain[i];
    network.inputs.push_back({spread.name, spread.mean, spread.sd, range.low, range.high});
  }
  network.actuators = data.inputs.actuators;
  network.wind = data.inputs.wind;
  const auto inputs = static_cast<Eigen::Index>(network.inputs.size());
  network.layers = {{Eigen::MatrixXd(kMembers * kUnits, inputs), Eigen::VectorXd(kMembers * kUnits)},
                    {Eigen::MatrixXd(3, kMembers * kUnits), Eigen::VectorXd::Zero(3)}};
  for (std::size_t m = 0; m < members.size(); ++m) {
    ResidualNetwork::Layer hidden, output;
    const float* next = read(members[m].parameters.data(), kUnits, inputs, hidden);
    read(next, 3, kUnits, output);
    const Eigen::Index first = static_cast<Eigen::Index>(m) * kUnits;
    network.layers[0].weights.middleRows(first, kUnits) = hidden.weights;
    network.layers[0].biases.segment(first, kUnits) = hidden.biases;
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Spread& acceleration = data.inputs.accelerations[k];
      const double scale = acceleration.sd / members[m].output_sd[k];
      network.layers[1].weights.block(i, first, 1, kUnits) = scale / kMembers * output.weights.row(i);
      network.layers[1].biases(i) +=
          (acceleration.mean + scale * (output.biases(i) - members[m].output_mean[k])) / kMembers;
    }
  }
  network.source = fmt::format("learned from {} recording{} on top of the ship; zero outside of what they cover",
                               recordings.size(), recordings.size() == 1 ? "" : "s");
  return std::make_shared<const ResidualNetwork>(std::move(network));
}

}  // namespace leeway::ensemble
