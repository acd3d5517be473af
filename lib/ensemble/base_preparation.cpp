#include "ensemble/base_preparation.hpp"

#include <cmath>

namespace leeway::ensemble {
namespace {

// Whether there is something to infer, which costs seconds.
bool infers(const TrainingConfig& config, const std::shared_ptr<const BaseModel>& base) {
  return base && config.base_spread != 0.0 && (!config.base_spread || config.fit_base);
}

// The networks start as large as what the fit leaves over, averaged over blocks of steps: differences of recorded
// velocities hold the sensors' noise besides, which is larger by far where the ship is right.
constexpr double kBlockSteps = 10.0;

void scale_networks(const Vec3<double>& acceleration_noise, TrainingData& data) {
  for (int i = 0; i < 3; ++i) {
    Spread& spread = data.inputs.accelerations[static_cast<std::size_t>(i)];
    spread.mean = 0.0;
    spread.sd = acceleration_noise(i) / std::sqrt(kBlockSteps * data.config.time_step_s);
  }
}

}  // namespace

TrainingData prepare_on_base(const std::vector<Trajectory>& recordings, const TrainingConfig& config,
                             const std::shared_ptr<const BaseModel>& base, std::optional<BaseSpreadEstimate>& found,
                             std::size_t jobs, const BaseModel* near) {
  TrainingData data = prepare_training_data(recordings, config, base);
  if (base && config.base_spread) data.base_spread = *config.base_spread;
  if (!infers(config, base)) return data;
  found = infer_base_spread(data, recordings, config.base_spread, jobs, near);
  data.base_spread = found->spread;
  if (!config.fit_base) return data;
  TrainingData fitted = prepare_training_data(recordings, config, calibrated(*base, *found));
  fitted.stated = base;
  fitted.base_spread = 1.0;
  scale_networks(found->acceleration_noise, fitted);
  return fitted;
}

TrainingData prepare_in_folder(const std::string& folder, const std::vector<Trajectory>& recordings,
                               const TrainingConfig& config, const std::shared_ptr<const BaseModel>& base,
                               std::uint64_t seed, const std::vector<TrainingFile>& files,
                               std::optional<BaseSpreadEstimate>& found, std::size_t jobs) {
  if (infers(config, base)) {
    const auto existing = read_header(folder, true);
    if (existing && existing->base && has_base_file(folder, *existing)) {
      const bool is_fitted = !existing->base->stated_sha256.empty();
      const std::string& given = is_fitted ? existing->base->stated_sha256 : existing->base->sha256;
      if (given == base->sha256() && is_fitted == config.fit_base) {
        TrainingData data = prepare_training_data(recordings, config, is_fitted ? read_base(folder, *existing) : base);
        if (is_fitted) {
          data.stated = base;
          data.inputs.accelerations = existing->inputs.accelerations;
        }
        data.base_spread = existing->base->spread;
        if (make_header(data, seed, files).training_id == existing->training_id) return data;
      }
    }
  }
  return prepare_on_base(recordings, config, base, found, jobs);
}

}  // namespace leeway::ensemble
