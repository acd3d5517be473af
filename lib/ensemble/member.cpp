#include "ensemble/member.hpp"

#include <algorithm>

namespace leeway::ensemble {

nn::NetworkShape dynamics_shape(const ModelInputs& inputs, const TrainingConfig& config) {
  return {static_cast<int>(inputs.inputs.size()), config.hidden_layers, config.hidden_units, 3};
}

nn::NetworkShape initial_state_shape(const ModelInputs& inputs, const TrainingConfig& config) {
  if (!config.initial_state_net) return {};
  return {static_cast<int>(inputs.initial_state.size()), config.hidden_layers, config.hidden_units, 6};
}

template <typename S>
RolloutConstants<S>::RolloutConstants(const ModelInputs& inputs, const TrainingConfig& config, const Member& member) {
  for (const Spread& input : inputs.inputs) {
    input_mean_.push_back(static_cast<S>(input.mean));
    input_inverse_sd_.push_back(static_cast<S>(1.0 / input.sd));
  }
  // The network's output is standardized by its own mean and deviation at initialization, then mapped to those of the
  // accelerations: one offset and one factor.
  for (std::size_t i = 0; i < 3; ++i) {
    const double mean = member.own_base ? member.own_base->acceleration_mean[i] : inputs.accelerations[i].mean;
    const double sd = member.own_base ? member.own_base->acceleration_sd[i] : inputs.accelerations[i].sd;
    const double scale = sd / member.output_sd[i];
    output_scale_.push_back(static_cast<S>(scale));
    output_offset_.push_back(static_cast<S>(mean - scale * member.output_mean[i]));
  }
  for (int i = 0; i < 3; ++i) initial_state_scale_.push_back(static_cast<S>(config.pose_scale(i)));
  for (int i = 0; i < 3; ++i) initial_state_scale_.push_back(static_cast<S>(config.sigma(i)));
  model_.dynamics = member.dynamics;
  model_.initial_state = member.initial_state;
  model_.controls = static_cast<int>(inputs.actuators.size());
  model_.wind = inputs.wind;
  model_.dt = static_cast<S>(config.time_step_s);
  model_.input_mean = input_mean_.data();
  model_.input_inverse_sd = input_inverse_sd_.data();
  model_.output_offset = output_offset_.data();
  model_.output_scale = output_scale_.data();
  model_.initial_state_scale = initial_state_scale_.data();
}

template <typename S>
void WindowBatch<S>::assign(const TrainingData& data, const std::vector<Window>& all, const std::size_t* windows,
                            std::size_t count, const BaseModel* base) {
  Eigen::Index longest = 0;
  double points = 0.0;
  for (std::size_t b = 0; b < count; ++b) {
    longest = std::max(longest, all[windows[b]].range.size);
    points += static_cast<double>(all[windows[b]].range.size);
  }
  const std::size_t K = static_cast<std::size_t>(longest), controls = data.inputs.actuators.size();
  const std::size_t start_inputs = data.inputs.initial_state.size();
  nu_.assign(K * count * 3, S(0));
  weight_.assign(K * count * 3, S(0));
  psi_.assign(count, S(0));
  controls_.assign(K * count * controls, S(0));
  wind_.assign(K * count * 2, S(0));
  initial_state_.assign(count * start_inputs, S(0));
  mask_.assign(count, S(0));
  for (std::size_t b = 0; b < count; ++b) {
    const Window& window = all[windows[b]];
    const Samples& s = data.stretches[window.stretch];
    psi_[b] = static_cast<S>(s.eta(2, window.range.begin));
    for (std::size_t k = 0; k < static_cast<std::size_t>(window.range.size); ++k) {
      const Eigen::Index at = window.range.begin + static_cast<Eigen::Index>(k);
      const std::size_t column = k * count + b;
      for (int i = 0; i < 3; ++i) {
        nu_[3 * column + i] = static_cast<S>(s.nu(i, at));
        weight_[3 * column + i] = static_cast<S>(1.0 / (data.config.sigma(i) * data.config.sigma(i)));
      }
      for (std::size_t a = 0; a < controls; ++a)
        controls_[controls * column + a] = static_cast<S>(s.actuators(static_cast<Eigen::Index>(a), at));
      for (int i = 0; i < 2; ++i) wind_[2 * column + i] = static_cast<S>(s.true_wind(i, at));
    }
    mask_[b] = window.initial_state_inputs.empty() ? S(0) : S(1);
    std::copy(window.initial_state_inputs.begin(), window.initial_state_inputs.end(),
              initial_state_.begin() + static_cast<std::ptrdiff_t>(b * start_inputs));
  }
  batch_.windows = static_cast<int>(count);
  batch_.points = static_cast<int>(K);
  batch_.nu_observed = nu_.data();
  batch_.weight = weight_.data();
  batch_.psi_initial = psi_.data();
  batch_.controls = controls_.data();
  batch_.true_wind = wind_.data();
  batch_.initial_state_inputs = initial_state_.data();
  batch_.initial_state_mask = mask_.data();
  batch_.count = points;
  base_ = base != nullptr ? base : data.base.get();
  assign_base(data, all, windows, count, K);
}

template <typename S>
void WindowBatch<S>::assign_base(const TrainingData& data, const std::vector<Window>& all, const std::size_t* windows,
                                 std::size_t count, std::size_t points) {
  batch_.base = {};
  if (base_ == nullptr) return;
  dt_s_ = data.config.time_step_s;
  batch_.base = {this, &base_rates};
  const std::vector<Channel> channels = data.inputs.sampled_actuators();
  base_inputs_.assign(points * count, std::nullopt);
  for (std::size_t b = 0; b < count; ++b) {
    const Window& window = all[windows[b]];
    for (Eigen::Index k = 0; k + 1 < window.range.size; ++k)
      base_inputs_[static_cast<std::size_t>(k) * count + b] =
          base_->inputs(data.stretches[window.stretch], channels, window.range.begin + k);
  }
}

template <typename S>
void WindowBatch<S>::base_rates(const void* batch, int step, int first, int n, const S* nu, const S* psi, S* rates,
                                S* derivatives) {
  const WindowBatch& self = *static_cast<const WindowBatch*>(batch);
  const std::size_t held_inputs =
      static_cast<std::size_t>(step) * static_cast<std::size_t>(self.batch_.windows) + static_cast<std::size_t>(first);
  for (std::size_t b = 0; b < static_cast<std::size_t>(n); ++b) {
    Eigen::Map<Eigen::Matrix<S, 4, 1>> rate(rates + 4 * b);
    Eigen::Map<Eigen::Matrix<S, 4, 4>> derivative(derivatives + 16 * b);
    const std::optional<Inputs<double>>& held = self.base_inputs_[held_inputs + b];
    if (!held) {
      rate.setZero();
      derivative.setZero();
      continue;
    }
    const Vec3<double> at = Eigen::Map<const Vec3<S>>(nu + 3 * b).template cast<double>();
    const BaseModel::MeanRates mean = self.base_->mean_rates(at, static_cast<double>(psi[b]), *held, self.dt_s_);
    rate = mean.rates.template cast<S>();
    derivative = mean.derivatives.template cast<S>();
  }
}

template class RolloutConstants<float>;
template class RolloutConstants<double>;
template class WindowBatch<float>;
template class WindowBatch<double>;

}  // namespace leeway::ensemble
