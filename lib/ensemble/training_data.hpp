#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ensemble/base_model.hpp"
#include "ensemble/config.hpp"
#include "recording/samples.hpp"
#include "recording/trajectory.hpp"

namespace leeway::ensemble {

/// Mean and standard deviation of one network input or output over the training data, SI and radians.
struct Spread {
  std::string name;  ///< "u_mps", "r_radps", "delta_p_rad", "app_wind_x_mps"
  double mean = 0.0, sd = 1.0;
};

/// Smallest and largest value of a network input in the training data, SI and radians.
struct InputRange {
  std::string name;
  double low = 0.0, high = 0.0;
};

/// What the networks see, found from the training data and kept with the model.
struct ModelInputs {
  std::vector<Channel> actuators;      ///< the recorded actuator channels that vary
  bool wind = false;                   ///< whether the apparent wind is an input
  std::vector<Spread> inputs;          ///< u, v_m, r, the actuators, apparent wind x and y in ship axes
  std::vector<Spread> accelerations;   ///< of u, v_m, r by numerical differentiation; with a base, what it leaves over
  std::vector<Spread> initial_state;   ///< inputs of the initial-state network, point by point; empty without it
  bool pose_in_initial_state = false;  ///< whether it sees the pose besides the velocities
  std::vector<std::pair<Channel, double>> constants;         ///< actuator channels left out since they never vary [SI]
  double largest_speed_mps = 0.0, largest_rate_radps = 0.0;  ///< range of the training data, for plausibility
  std::vector<Channel> base_actuators;  ///< never vary in the training data, but the base model reads them
  std::vector<InputRange> domain;       ///< of `inputs`

  /// What a recording is sampled for: the networks' actuators, then those of the base model alone.
  std::vector<Channel> sampled_actuators() const;
};

/// A training window: its place in the data, and the standardized input of the initial-state network.
struct Window {
  std::size_t stretch = 0;
  Range range;
  std::vector<float> initial_state_inputs;  ///< empty where the window is shorter than initial_state_steps
};

struct TrainingFile {
  std::string file, sha256;
  std::size_t rows = 0;
};

/// Training data on the time grid of the config, cut into windows that hold every point.
struct TrainingData {
  TrainingConfig config;
  ModelInputs inputs;
  std::vector<Samples> stretches;
  std::vector<Window> windows;
  std::vector<std::vector<Window>> curriculum;  ///< of each stage of config.curriculum
  std::vector<std::string> notices;             ///< what the user should know: columns left out, files too short
  std::shared_ptr<const BaseModel> base = nullptr;
  std::shared_ptr<const BaseModel> stated = nullptr;  ///< the ship that `base` was fitted from, where it was
  /// What the base ship's stated uncertainty is multiplied by where members learn on draws from it; 0: all learn on the
  /// base ship itself.
  double base_spread = 0.0;
  bool has_drawn_base = false;  ///< `base` is a member's own

  /// The windows that an epoch (from 0) is trained on.
  const std::vector<Window>& windows_of_epoch(int epoch) const;
};

/// Finds the inputs, resamples, standardizes and cuts. Throws InputError where the data cannot train anything: no two
/// points, a velocity that never varies, no actuator and no wind that varies, a column missing in one of the files, or
/// one that the base model needs.
///   base  nothing: the networks learn the whole accelerations
TrainingData prepare_training_data(std::vector<Trajectory> recordings, const TrainingConfig& config,
                                   std::shared_ptr<const BaseModel> base = nullptr);

/// The data as a member sees them: on its own draw of the base ship, where base_spread is not zero.
TrainingData data_of_member(const TrainingData& data, std::uint64_t seed, int number);
/// The draws that members learn on.
ShipDraws draws_of_members(const TrainingData& data, std::uint64_t seed);

/// Other recordings as the members of a training see them: its inputs, its standardization, its base. For evaluation.
/// Throws InputError where one lacks a column that the training has, or none holds two points of the time grid.
TrainingData prepare_held_out_data(std::vector<Trajectory> recordings, const TrainingData& training);

/// Inputs of the initial-state network before standardization: for each of the first `steps` points of the range
/// x, y [m] and heading [rad] relative to the first point in its ship axes (where recorded), then u, v_m, r.
std::vector<double> initial_state_observations(const Samples& samples, Range range, int steps, bool with_pose);

}  // namespace leeway::ensemble
