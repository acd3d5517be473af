#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ensemble/training_data.hpp"
#include "nn/rollout.hpp"

namespace leeway::ensemble {

/// The ship of a member that does not learn on that of the whole ensemble, but on a draw from it.
struct OwnBase {
  std::string sha256;                                            ///< of its JSON
  std::array<double, 3> acceleration_mean{}, acceleration_sd{};  ///< of what it leaves over of u', v_m', r'
};

/// One trained pair of networks.
struct Member {
  int number = 0;
  std::string kernel;  ///< that began its training, and decides its last bits: nn::give_same_bits()
  nn::NetworkShape dynamics, initial_state;
  nn::AlignedVector<float> parameters;  ///< dynamics, then initial state
  std::array<double, 3> output_mean{};  ///< of the dynamics network over standard normal inputs at initialization
  std::array<double, 3> output_sd{};
  std::optional<OwnBase> own_base = std::nullopt;
  std::vector<float> training_curve;  ///< mean training loss of each epoch
};

nn::NetworkShape dynamics_shape(const ModelInputs& inputs, const TrainingConfig& config);
nn::NetworkShape initial_state_shape(const ModelInputs& inputs, const TrainingConfig& config);

/// The constants of a member's rollout in the precision of a kernel; view() points into this object.
template <typename S>
class RolloutConstants {
 public:
  RolloutConstants(const ModelInputs& inputs, const TrainingConfig& config, const Member& member);
  const nn::RolloutModel<S>& view() const { return model_; }
  RolloutConstants(const RolloutConstants&) = delete;
  RolloutConstants& operator=(const RolloutConstants&) = delete;

 private:
  nn::AlignedVector<S> input_mean_, input_inverse_sd_, output_offset_, output_scale_, initial_state_scale_;
  nn::RolloutModel<S> model_;
};

/// Windows of the training data side by side, as a kernel wants them.
template <typename S>
class WindowBatch {
 public:
  WindowBatch() = default;
  WindowBatch(const WindowBatch&) = delete;  // view() may point into it
  WindowBatch& operator=(const WindowBatch&) = delete;
  /// Fills the batch with the given windows of data.windows, or of others on the same data.
  void assign(const TrainingData& data, const std::size_t* windows, std::size_t count) {
    assign(data, data.windows, windows, count);
  }
  ///   base  in place of that of the data; nothing: that of the data
  void assign(const TrainingData& data, const std::vector<Window>& all, const std::size_t* windows, std::size_t count,
              const BaseModel* base = nullptr);
  const nn::RolloutBatch<S>& view() const { return batch_; }
  double points() const { return batch_.count; }

 private:
  void assign_base(const TrainingData& data, const std::vector<Window>& all, const std::size_t* windows,
                   std::size_t count, std::size_t points);
  static void base_rates(const void* batch, int step, int first, int n, const S* nu, const S* psi, S* rates,
                         S* derivatives);

  nn::AlignedVector<S> nu_, weight_, psi_, controls_, wind_, initial_state_, mask_;
  nn::RolloutBatch<S> batch_;
  const BaseModel* base_ = nullptr;
  double dt_s_ = 0.0;
  std::vector<std::optional<Inputs<double>>> base_inputs_;  ///< [points][windows], nothing beyond a window's end
};

}  // namespace leeway::ensemble
