#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ensemble/base_spread.hpp"
#include "ensemble/model_files.hpp"

namespace leeway::ensemble {

/// Data to train on, with what the members' ships are drawn from: where the config says so, the scale S of what the
/// base ship states is inferred, and the ship is fitted.
///   base   as given to the training; nothing: no base
///   found  what was inferred, if anything
///   jobs   threads; the result does not depend on them
///   near   as of infer_base_spread()
TrainingData prepare_on_base(const std::vector<Trajectory>& recordings, const TrainingConfig& config,
                             const std::shared_ptr<const BaseModel>& base, std::optional<BaseSpreadEstimate>& found,
                             std::size_t jobs = 1, const BaseModel* near = nullptr);

/// The same with what an earlier process has inferred, where the folder's training is that of these recordings, config,
/// base and seed.
TrainingData prepare_in_folder(const std::string& folder, const std::vector<Trajectory>& recordings,
                               const TrainingConfig& config, const std::shared_ptr<const BaseModel>& base,
                               std::uint64_t seed, const std::vector<TrainingFile>& files,
                               std::optional<BaseSpreadEstimate>& found, std::size_t jobs = 1);

}  // namespace leeway::ensemble
