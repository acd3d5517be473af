#pragma once

#include "nn/propagation.hpp"

/// The loss of windows side by side and its gradient through time. For rollout_kernel.cpp alone, as vector.hpp.
namespace leeway::nn::LEEWAY_KERNEL {
namespace {

// Some windows of a batch as lanes, through time and back.
template <int C, typename S>
class BlockRollout {
 public:
  BlockRollout(Work<S>& work, const RolloutModel<S>& model, const RolloutBatch<S>& batch, int first, int windows)
      : w_(work),
        model_(model),
        batch_(batch),
        first_(first),
        windows_(windows),
        steps_(batch.points - 1),
        has_base_(batch.base.evaluate != nullptr),
        has_start_(model.initial_state.outputs > 0) {
    const long points = batch.points, inputs = model.dynamics.inputs;
    w_.dynamics_work.reserve(w_.dynamics, steps_, L);
    w_.inputs.reserve(steps_ * inputs * L);
    w_.nu.reserve(points * 3 * L);
    w_.error.reserve(points * 3 * L);
    w_.psi.reserve(points * L);
    w_.wind_x.reserve(steps_ * L);
    w_.wind_y.reserve(steps_ * L);
    w_.lambda.reserve(4L * L);
    w_.input_derivative.reserve(inputs * L);
    if (has_start_) {
      w_.initial_state_work.reserve(w_.initial_state, 1, L);
      w_.start_inputs.reserve(static_cast<long>(model.initial_state.inputs) * L);
    }
    if (has_base_) {
      w_.base_nu.reserve(3L * L);
      w_.base_psi.reserve(L);
      w_.base_rates.reserve(4L * L);
      w_.base_derivatives.reserve(16L * L * steps_);
    }
  }

  // The loss, not yet divided by the batch's count; adds to the gradients in the work.
  double run() {
    start();
    for (int k = 0; k < steps_; ++k) step(k);
    const double loss = compare();
    for (int k = steps_ - 1; k >= 0; --k) step_back(k);
    if (has_start_) start_back();
    return loss;
  }

 private:
  static constexpr int L = C * kWidth<S>;

  // Lanes beyond the last window repeat it, so that they stay finite where it does; their derivatives are zero.
  long window(int lane) const { return first_ + (lane < windows_ ? lane : windows_ - 1); }
  long column(int point, int lane) const { return static_cast<long>(point) * batch_.windows + window(lane); }
  S* nu(int point, int axis) { return w_.nu.at((3L * point + axis) * L); }
  S* psi(int point) { return w_.psi.at(static_cast<long>(point) * L); }
  S* error(int point, int axis) { return w_.error.at((3L * point + axis) * L); }
  S* lambda(int state) { return w_.lambda.at(static_cast<long>(state) * L); }  // of (u, v_m, r, psi)

  // The observed state plus the correction of the initial-state network.
  void start() {
    for (int b = 0; b < L; ++b) {
      for (int i = 0; i < 3; ++i) nu(0, i)[b] = batch_.nu_observed[3 * window(b) + i];
      psi(0)[b] = batch_.psi_initial[window(b)];
    }
    if (!has_start_) return;
    const int inputs = model_.initial_state.inputs;
    for (int j = 0; j < inputs; ++j)
      for (int b = 0; b < L; ++b)
        w_.start_inputs.at(static_cast<long>(j) * L)[b] = batch_.initial_state_inputs[window(b) * inputs + j];
    forward_step<C>(w_.initial_state, w_.start_inputs.at(0), 0, w_.initial_state_work);
    const S* output = w_.initial_state_work.output.at(0);
    for (int b = 0; b < L; ++b) {
      const S mask = batch_.initial_state_mask[window(b)];
      psi(0)[b] += mask * model_.initial_state_scale[2] * output[2 * L + b];
      for (int i = 0; i < 3; ++i) nu(0, i)[b] += mask * model_.initial_state_scale[3 + i] * output[(3 + i) * L + b];
    }
  }

  // Euler from k to k + 1 with the inputs of k.
  void step(int k) {
    S* inputs = w_.inputs.at(static_cast<long>(k) * model_.dynamics.inputs * L);
    const int controls = model_.controls;
    for (int b = 0; b < L; ++b) {
      for (int i = 0; i < 3; ++i) inputs[i * L + b] = nu(k, i)[b];
      for (int a = 0; a < controls; ++a) inputs[(3 + a) * L + b] = batch_.controls[column(k, b) * controls + a];
    }
    if (model_.wind) {
      S* x = w_.wind_x.at(static_cast<long>(k) * L);
      S* y = w_.wind_y.at(static_cast<long>(k) * L);
      for (int b = 0; b < L; ++b) {
        x[b] = batch_.true_wind[2 * column(k, b)];
        y[b] = batch_.true_wind[2 * column(k, b) + 1];
      }
      for (int b = 0; b < L; b += kWidth<S>) {
        Vector<S> sine, cosine;
        sine_cosine(load(psi(k) + b), sine, cosine);
        const Vector<S> along = cosine * load(x + b) + sine * load(y + b);
        const Vector<S> across = cosine * load(y + b) - sine * load(x + b);
        store<S>(x + b, along);
        store<S>(y + b, across);
        store<S>(inputs + (3 + controls) * L + b, along + load(nu(k, 0) + b));
        store<S>(inputs + (4 + controls) * L + b, across + load(nu(k, 1) + b));
      }
    }
    for (int j = 0; j < model_.dynamics.inputs; ++j)
      for (int b = 0; b < L; ++b)
        inputs[j * L + b] = (inputs[j * L + b] - model_.input_mean[j]) * model_.input_inverse_sd[j];
    forward_step<C>(w_.dynamics, inputs, k, w_.dynamics_work);
    const S* output = w_.dynamics_work.output.at(0);
    for (int i = 0; i < 3; ++i)
      for (int b = 0; b < L; ++b)
        nu(k + 1, i)[b] =
            nu(k, i)[b] + model_.dt * (model_.output_offset[i] + model_.output_scale[i] * output[i * L + b]);
    if (has_base_)
      add_base(k);
    else
      for (int b = 0; b < L; ++b) psi(k + 1)[b] = psi(k)[b] + model_.dt * nu(k, 2)[b];
  }

  // Adds the change by the base rates to point k + 1.
  void add_base(int k) {
    for (int b = 0; b < L; ++b) {
      for (int i = 0; i < 3; ++i) w_.base_nu.at(0)[3 * b + i] = nu(k, i)[b];
      w_.base_psi.at(0)[b] = psi(k)[b];
    }
    const S* rates = w_.base_rates.at(0);
    batch_.base.evaluate(batch_.base.object, k, first_, windows_, w_.base_nu.at(0), w_.base_psi.at(0),
                         w_.base_rates.at(0), w_.base_derivatives.at(16L * L * k));
    for (int b = 0; b < L; ++b) {
      const long of = window(b) - first_;
      for (int i = 0; i < 3; ++i) nu(k + 1, i)[b] += model_.dt * rates[4 * of + i];
      psi(k + 1)[b] = psi(k)[b] + model_.dt * rates[4 * of + 3];
    }
  }

  // The loss; its derivatives by each point's velocity go to error().
  double compare() {
    const S twice = static_cast<S>(2.0 / batch_.count);
    double loss = 0.0;
    for (int k = 0; k <= steps_; ++k)
      for (int b = 0; b < L; ++b)
        for (int i = 0; i < 3; ++i) {
          const S difference = nu(k, i)[b] - batch_.nu_observed[3 * column(k, b) + i];
          const S weight = b < windows_ ? batch_.weight[3 * column(k, b) + i] : S(0);
          loss += static_cast<double>(weight) * difference * difference;
          error(k, i)[b] = twice * weight * difference;
        }
    for (int b = 0; b < L; ++b) {
      for (int i = 0; i < 3; ++i) lambda(i)[b] = error(steps_, i)[b];
      lambda(3)[b] = S(0);
    }
    return loss;
  }

  // lambda, the loss derivative by the state, from k + 1 to k.
  void step_back(int k) {
    S* output_delta = w_.dynamics_work.output_delta.at(0);
    for (int i = 0; i < 3; ++i)
      for (int b = 0; b < L; ++b) output_delta[i * L + b] = model_.dt * model_.output_scale[i] * lambda(i)[b];
    S* by_input = w_.input_derivative.at(0);
    backward_step<C>(w_.dynamics, w_.inputs.at(0), k, steps_, w_.dynamics_work, by_input);
    for (int j = 0; j < model_.dynamics.inputs; ++j)
      for (int b = 0; b < L; ++b) by_input[j * L + b] *= model_.input_inverse_sd[j];
    if (has_base_)
      pull_back_through_base(k);
    else
      for (int b = 0; b < L; ++b) lambda(2)[b] += model_.dt * lambda(3)[b];
    for (int i = 0; i < 3; ++i)
      for (int b = 0; b < L; ++b) lambda(i)[b] += by_input[i * L + b] + error(k, i)[b];
    if (!model_.wind) return;
    const S* dx = by_input + (3 + model_.controls) * L;
    const S* dy = dx + L;
    const S* along = w_.wind_x.at(static_cast<long>(k) * L);
    const S* across = w_.wind_y.at(static_cast<long>(k) * L);
    for (int b = 0; b < L; ++b) {
      lambda(0)[b] += dx[b];
      lambda(1)[b] += dy[b];
      lambda(3)[b] += dx[b] * across[b] - dy[b] * along[b];
    }
  }

  // The part that goes through the base rates.
  void pull_back_through_base(int k) {
    for (int b = 0; b < windows_; ++b) {
      const S* by_state = w_.base_derivatives.at(16L * L * k) + 16 * b;
      S more[4] = {};
      for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) more[j] += by_state[4 * j + i] * lambda(i)[b];
      for (int j = 0; j < 4; ++j) lambda(j)[b] += model_.dt * more[j];
    }
  }

  void start_back() {
    S* delta = w_.initial_state_work.output_delta.at(0);
    for (int b = 0; b < L; ++b) {
      const S mask = batch_.initial_state_mask[window(b)];
      delta[b] = delta[L + b] = S(0);  // the position is not in the loss
      delta[2 * L + b] = mask * model_.initial_state_scale[2] * lambda(3)[b];
      for (int i = 0; i < 3; ++i) delta[(3 + i) * L + b] = mask * model_.initial_state_scale[3 + i] * lambda(i)[b];
    }
    backward_step<C, S>(w_.initial_state, w_.start_inputs.at(0), 0, 1, w_.initial_state_work, nullptr);
  }

  Work<S>& w_;
  const RolloutModel<S>& model_;
  const RolloutBatch<S>& batch_;
  const int first_, windows_, steps_;
  const bool has_base_, has_start_;
};

// At most C vectors of windows, in the smallest block of 1, 2, 4 .. vectors that holds them.
template <int C, typename S>
double run_block(Work<S>& work, const RolloutModel<S>& model, const RolloutBatch<S>& batch, int first, int windows) {
  if constexpr (C > 1)
    if (windows <= C / 2 * kWidth<S>) return run_block<C / 2>(work, model, batch, first, windows);
  return BlockRollout<C, S>(work, model, batch, first, windows).run();
}

template <typename S>
double loss_and_gradient(void* memory, const RolloutModel<S>& model, const RolloutBatch<S>& batch, const S* parameters,
                         S* gradient) {
  Work<S>& w = *static_cast<Work<S>*>(memory);
  const bool has_start = model.initial_state.outputs > 0;
  const long start_offset = offset_of(model.dynamics, model.dynamics.hidden_layers + 1);
  w.dynamics.pack(model.dynamics, parameters, true);
  w.dynamics_work.clear_gradient(w.dynamics);
  if (has_start) {
    w.initial_state.pack(model.initial_state, parameters + start_offset, true);
    w.initial_state_work.clear_gradient(w.initial_state);
  }
  double loss = 0.0;
  for (int first = 0; first < batch.windows;) {
    const int left = batch.windows - first, windows = left < kBlockLanes ? left : kBlockLanes;
    loss += run_block<kBlockLanes / kWidth<S>>(w, model, batch, first, windows);
    first += windows;
  }
  w.dynamics_work.copy_gradient(w.dynamics, gradient);
  if (has_start) w.initial_state_work.copy_gradient(w.initial_state, gradient + start_offset);
  return loss / batch.count;
}

}  // namespace
}  // namespace leeway::nn::LEEWAY_KERNEL
