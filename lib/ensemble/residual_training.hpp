#pragma once

#include <memory>
#include <vector>

#include "ensemble/training_data.hpp"
#include "ship/ship.hpp"

namespace leeway::ensemble {

struct ResidualTraining {
  double time_step_s = 1.0;
  Vec3<double> sigma{0.01, 0.01, 0.1 * kDegree};  ///< of the recorded u, v_m [m/s], r [rad/s]
  std::uint64_t seed = 1;
  std::size_t jobs = 1;
};

/// What a ship's model leaves over in recordings as one small network: the mean of three members with 16 units each,
/// trained by rollout on top of the model as ens-train --base does. The same bits for any number of jobs. Throws
/// InputError where the ship has an effect that a base model cannot have, or the recordings cannot train anything.
std::shared_ptr<const ResidualNetwork> learn_residual(const Ship& ship, const std::vector<Trajectory>& recordings,
                                                      const ResidualTraining& training);

}  // namespace leeway::ensemble
