#pragma once

#include <string>

#include "core/types.hpp"
#include "core/units.hpp"
#include "dynamics/integrator.hpp"
#include "io/json.hpp"
#include "recording/samples.hpp"

namespace leeway::ensemble {

enum class RateSchedule {
  constant,  ///< the paper's
  cosine     ///< falls from learning_rate to zero over all epochs along half a cosine
};

/// How an ensemble is trained: the keys of configs/train/*.json. The defaults are the ensemble paper's.
struct TrainingConfig {
  double time_step_s = 1.0;
  int steps = 100;               ///< points K of a training window: K - 1 integration steps
  int initial_state_steps = 30;  ///< points that the initial-state network sees
  int hidden_layers = 3;
  int hidden_units = 256;
  /// Standard deviations of the observation errors (u, v_m [m/s], r [rad/s]) that weigh the loss.
  Vec3<double> sigma{0.01, 0.01, 0.1 * kDegree};
  double learning_rate = 1e-4;
  RateSchedule schedule = RateSchedule::constant;
  double gradient_clip_norm = 0.0;  ///< 0: gradients are not clipped
  int batch_size = 32;
  int epochs = 20000;
  int members = 15;
  bool initial_state_net = true;
  /// Size of the initial-state network's unit output for (x0, y0 [m], psi [rad]); for velocities it is sigma.
  Vec3<double> pose_scale{0.03, 0.03, 0.1 * kDegree};
  Integrator integrator_predict = Integrator::rk4;
  StateResampling resampling = StateResampling::decimate;
};

/// Reads and checks a training config (path, "-" or the name of a shipped one). Throws InputError.
TrainingConfig read_training_config(const std::string& name_or_path);
TrainingConfig training_config_from(const io::JsonObject& object);

/// All keys with their values, in the units of the file.
io::Json to_json(const TrainingConfig& config);

}  // namespace leeway::ensemble
