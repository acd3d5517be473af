#pragma once

#include <optional>
#include <string>
#include <vector>

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

enum class Optimizer {
  adam,  ///< the paper's
  muon   ///< hidden matrices by orthogonalized momentum (muon.hpp), the rest by Adam
};

/// Part of the epochs that is trained on shorter windows.
struct CurriculumStage {
  int steps = 0;       ///< points K of its windows
  double share = 0.0;  ///< of the epochs

  friend bool operator==(const CurriculumStage&, const CurriculumStage&) = default;
};

/// What cross_fit() holds out, and how many networks it trains for each part.
struct CrossFitConfig {
  int folds = 4;
  int members = 6;

  friend bool operator==(const CrossFitConfig&, const CrossFitConfig&) = default;
};

/// How an ensemble is trained: the keys of configs/train/*.json. The defaults are the ensemble paper's.
struct TrainingConfig {
  /// "paper": method and numbers are those of the ensemble paper at one of its two scales, which reading has checked.
  std::string follows;
  double time_step_s = 1.0;
  int steps = 100;  ///< points K of a training window: K - 1 integration steps
  /// Stages before windows have K = steps: rollouts that grow with what the networks know.
  std::vector<CurriculumStage> curriculum;
  int initial_state_steps = 30;  ///< points that the initial-state network sees
  int hidden_layers = 3;
  int hidden_units = 256;
  /// Standard deviations of the observation errors (u, v_m [m/s], r [rad/s]) that weigh the loss.
  Vec3<double> sigma{0.01, 0.01, 0.1 * kDegree};
  double learning_rate = 1e-4;
  double gradient_clip_norm = 0.0;  ///< 0: gradients are not clipped
  RateSchedule schedule = RateSchedule::constant;
  Optimizer optimizer = Optimizer::adam;
  double muon_rate_factor = 3.0;  ///< Muon's rate over Adam's
  int batch_size = 32;
  int epochs = 20000;
  int members = 15;
  /// What the stated uncertainty of a base ship is multiplied by, where members learn on draws from it; 0: all on the
  /// ship itself; nothing: inferred from the recordings (base_spread.hpp).
  std::optional<double> base_spread = 0.0;
  /// The base ship is fitted to the recordings first, and members are drawn from what these leave open of what it
  /// states.
  bool fit_base = false;
  bool bootstrap = false;  ///< each member learns on as many recordings, drawn with replacement
  bool initial_state_net = true;
  /// Size of the initial-state network's unit output for (x0, y0 [m], psi [rad]); for velocities it is sigma.
  Vec3<double> pose_scale{0.03, 0.03, 0.1 * kDegree};
  Integrator integrator_predict = Integrator::rk4;
  StateResampling resampling = StateResampling::decimate;
  /// With linear paths particles draw what these leave open of the inputs' means.
  InputPath inputs = InputPath::held;
  /// Disturbance, sensor noise and radii by cross-fitting, once all members are trained; nothing: none.
  std::optional<CrossFitConfig> calibration = std::nullopt;
};

/// Reads and checks a training config (path, "-" or the name of a shipped one). Throws InputError.
TrainingConfig read_training_config(const std::string& name_or_path);
TrainingConfig training_config_from(const io::JsonObject& object);

/// The stage that an epoch (from 0) belongs to: an index of config.curriculum, or its size for the whole windows.
std::size_t curriculum_stage(const TrainingConfig& config, int epoch);

/// The rate of an optimizer step when the share `progress` of all steps is done.
double learning_rate(const TrainingConfig& config, double progress);

/// All keys with their values, in the units of the file; but those of curriculum and Muon, and `follows`, only where
/// they are used, so that trainings without them keep their identity.
io::Json to_json(const TrainingConfig& config);

}  // namespace leeway::ensemble
