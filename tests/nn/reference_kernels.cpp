#include "nn/reference_kernels.hpp"

#include <Eigen/Core>

namespace leeway::test {
namespace {

using nn::BaseRates;
using nn::NetworkShape;
using nn::RolloutBatch;
using nn::RolloutModel;

template <typename S>
using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
template <typename S>
using Vector = Eigen::Matrix<S, Eigen::Dynamic, 1>;
template <typename S>
using ConstMatrix = Eigen::Map<const Matrix<S>>;

constexpr int kMostLayers = 16;

// Scratch memory of one network over all columns that it is evaluated for.
template <typename S>
struct NetworkWork {
  Matrix<S> hidden[kMostLayers];     // tanh outputs, units x columns
  Matrix<S> delta[kMostLayers + 1];  // loss derivatives before tanh; the last one belongs to the output layer
  Matrix<S> output;

  void resize(const NetworkShape& shape, Eigen::Index columns, bool with_deltas) {
    for (int l = 0; l < shape.hidden_layers; ++l) hidden[l].resize(shape.hidden_units, columns);
    output.resize(shape.outputs, columns);
    if (!with_deltas) return;
    for (int l = 0; l < shape.hidden_layers; ++l) delta[l].resize(shape.hidden_units, columns);
    delta[shape.hidden_layers].resize(shape.outputs, columns);
  }
};

template <typename S>
struct Work {
  NetworkWork<S> dynamics, initial_state;
  Matrix<S> inputs;             // standardized inputs of the dynamics network, all steps
  Matrix<S> nu, error;          // 3 x windows*points
  Matrix<S> psi, cosine, sine;  // 1 x windows*points
  Matrix<S> lambda_nu, lambda_psi, input_derivative;
  Matrix<S> base_rates, base_derivatives;  // 4 x windows; 4 x 4*windows*steps
};

int inputs_of(const NetworkShape& s, int layer) { return layer == 0 ? s.inputs : s.hidden_units; }
int outputs_of(const NetworkShape& s, int layer) { return layer == s.hidden_layers ? s.outputs : s.hidden_units; }

// Position of a layer's weights in the parameters; its biases follow them.
Eigen::Index offset_of(const NetworkShape& s, int layer) {
  Eigen::Index offset = 0;
  for (int l = 0; l < layer; ++l) offset += static_cast<Eigen::Index>(outputs_of(s, l)) * (inputs_of(s, l) + 1);
  return offset;
}

// Evaluates columns [begin, begin + n) of the network's work; `inputs` holds all columns.
template <typename S, typename Inputs>
void forward_columns(const NetworkShape& shape, const S* parameters, const Inputs& inputs, NetworkWork<S>& work,
                     Eigen::Index begin, Eigen::Index n) {
  for (int l = 0; l <= shape.hidden_layers; ++l) {
    const int rows = outputs_of(shape, l), cols = inputs_of(shape, l);
    const S* layer = parameters + offset_of(shape, l);
    const ConstMatrix<S> weights(layer, rows, cols);
    const Eigen::Map<const Vector<S>> bias(layer + static_cast<Eigen::Index>(rows) * cols, rows);
    Matrix<S>& target = l == shape.hidden_layers ? work.output : work.hidden[l];
    auto out = target.middleCols(begin, n);
    if (l == 0)
      out.noalias() = weights * inputs.middleCols(begin, n);
    else
      out.noalias() = weights * work.hidden[l - 1].middleCols(begin, n);
    for (Eigen::Index c = 0; c < n; ++c) {
      if (l == shape.hidden_layers)
        out.col(c) += bias;
      else
        out.col(c) = (out.col(c) + bias).array().tanh().matrix();
    }
  }
}

// From the output layer's deltas in columns [begin, begin + n) to those of the hidden layers, and to the derivative
// with respect to the first `inputs` inputs (none if 0).
template <typename S>
void backward_columns(const NetworkShape& shape, const S* parameters, NetworkWork<S>& work, Eigen::Index begin,
                      Eigen::Index n, Matrix<S>* input_derivative) {
  for (int l = shape.hidden_layers; l >= 0; --l) {
    const ConstMatrix<S> weights(parameters + offset_of(shape, l), outputs_of(shape, l), inputs_of(shape, l));
    const auto delta = work.delta[l].middleCols(begin, n);
    if (l == 0) {
      if (input_derivative != nullptr) input_derivative->noalias() = weights.transpose() * delta;
      return;
    }
    auto below = work.delta[l - 1].middleCols(begin, n);
    below.noalias() = weights.transpose() * delta;
    below.array() *= S(1) - work.hidden[l - 1].middleCols(begin, n).array().square();
  }
}

// The weight gradients of all columns at once.
template <typename S, typename Inputs>
void parameter_gradient(const NetworkShape& shape, const Inputs& inputs, const NetworkWork<S>& work, S* gradient) {
  for (int l = 0; l <= shape.hidden_layers; ++l) {
    const int rows = outputs_of(shape, l), cols = inputs_of(shape, l);
    S* layer = gradient + offset_of(shape, l);
    Eigen::Map<Matrix<S>> weights(layer, rows, cols);
    Eigen::Map<Vector<S>> bias(layer + static_cast<Eigen::Index>(rows) * cols, rows);
    if (l == 0)
      weights.noalias() = work.delta[l] * inputs.transpose();
    else
      weights.noalias() = work.delta[l] * work.hidden[l - 1].transpose();
    bias = work.delta[l].rowwise().sum();
  }
}

// Adds the change by the base rates to point k + 1 of the rollout.
template <typename S>
void add_base(const BaseRates<S>& base, int k, Eigen::Index B, S dt, Work<S>& w) {
  const Eigen::Index c = k * B;
  base.evaluate(base.object, k, 0, static_cast<int>(B), w.nu.data() + 3 * c, w.psi.data() + c, w.base_rates.data(),
                w.base_derivatives.data() + 16 * c);
  w.nu.middleCols(c + B, B) += dt * w.base_rates.topRows(3);
  w.psi.middleCols(c + B, B) = w.psi.middleCols(c, B) + dt * w.base_rates.row(3);
}

// From the loss derivatives by the state at k + 1 to their part by the state at k that goes through the base rates and
// through the state itself.
template <typename S>
void pull_back_through_base(Eigen::Index k, Eigen::Index B, S dt, Work<S>& w) {
  for (Eigen::Index b = 0; b < B; ++b) {
    const S* by_state = w.base_derivatives.data() + 16 * (k * B + b);
    const S lambda[4] = {w.lambda_nu(0, b), w.lambda_nu(1, b), w.lambda_nu(2, b), w.lambda_psi(0, b)};
    S more[4] = {};
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) more[j] += by_state[4 * j + i] * lambda[i];
    for (int j = 0; j < 3; ++j) w.lambda_nu(j, b) += dt * more[j];
    w.lambda_psi(0, b) += dt * more[3];
  }
}

}  // namespace

template <typename S>
double reference_loss_and_gradient(const RolloutModel<S>& model, const RolloutBatch<S>& batch, const S* parameters,
                                   S* gradient) {
  Work<S> w;
  const Eigen::Index B = batch.windows, K = batch.points, steps = K - 1;
  const NetworkShape& net = model.dynamics;
  const NetworkShape& start = model.initial_state;
  const int wind_row = 3 + model.controls;
  const S* start_parameters = parameters + offset_of(net, (net.hidden_layers + 1));
  const ConstMatrix<S> observed(batch.nu_observed, 3, B * K), weight(batch.weight, 3, B * K);
  const ConstMatrix<S> controls(batch.controls, model.controls, B * K),
      true_wind(batch.true_wind, 2, model.wind ? B * K : 0);
  const ConstMatrix<S> start_inputs(batch.initial_state_inputs, start.inputs, start.outputs > 0 ? B : 0);
  const Eigen::Map<const Vector<S>> mean(model.input_mean, net.inputs), inverse_sd(model.input_inverse_sd, net.inputs);
  const Eigen::Map<const Vector<S>> output_offset(model.output_offset, 3), output_scale(model.output_scale, 3);

  w.dynamics.resize(net, B * steps, true);
  w.inputs.resize(net.inputs, B * steps);
  w.nu.resize(3, B * K);
  w.psi.resize(1, B * K);
  w.cosine.resize(1, B * K);
  w.sine.resize(1, B * K);
  const bool has_base = batch.base.evaluate != nullptr;
  if (has_base) {
    w.base_rates.resize(4, B);
    w.base_derivatives.resize(4, 4 * B * steps);
  }

  // Start: the observed state plus the correction of the initial-state network.
  w.nu.leftCols(B) = observed.leftCols(B);
  w.psi.leftCols(B) = Eigen::Map<const Eigen::Matrix<S, 1, Eigen::Dynamic>>(batch.psi_initial, B);
  if (start.outputs > 0) {
    w.initial_state.resize(start, B, true);
    forward_columns(start, start_parameters, start_inputs, w.initial_state, 0, B);
    for (Eigen::Index b = 0; b < B; ++b) {
      const S mask = batch.initial_state_mask[b];
      w.psi(0, b) += mask * model.initial_state_scale[2] * w.initial_state.output(2, b);
      for (int i = 0; i < 3; ++i)
        w.nu(i, b) += mask * model.initial_state_scale[3 + i] * w.initial_state.output(3 + i, b);
    }
  }

  // Rollout by Euler; the inputs of step k act from k to k + 1.
  for (Eigen::Index k = 0; k < steps; ++k) {
    const Eigen::Index c = k * B;
    auto inputs = w.inputs.middleCols(c, B);
    const auto nu = w.nu.middleCols(c, B);
    inputs.topRows(3) = nu;
    inputs.middleRows(3, model.controls) = controls.middleCols(c, B);
    if (model.wind) {
      auto cosine = w.cosine.middleCols(c, B).array();
      auto sine = w.sine.middleCols(c, B).array();
      cosine = w.psi.middleCols(c, B).array().cos();
      sine = w.psi.middleCols(c, B).array().sin();
      const auto x = true_wind.middleCols(c, B).row(0).array(), y = true_wind.middleCols(c, B).row(1).array();
      inputs.row(wind_row).array() = cosine * x + sine * y + nu.row(0).array();
      inputs.row(wind_row + 1).array() = cosine * y - sine * x + nu.row(1).array();
    }
    for (Eigen::Index b = 0; b < B; ++b) inputs.col(b) = (inputs.col(b) - mean).cwiseProduct(inverse_sd);
    forward_columns(net, parameters, w.inputs, w.dynamics, c, B);
    for (Eigen::Index b = 0; b < B; ++b)
      w.nu.col(c + B + b) =
          w.nu.col(c + b) + model.dt * (output_offset + output_scale.cwiseProduct(w.dynamics.output.col(c + b)));
    if (has_base)
      add_base(batch.base, static_cast<int>(k), B, model.dt, w);
    else
      w.psi.middleCols(c + B, B) = w.psi.middleCols(c, B) + model.dt * nu.row(2);
  }

  // Loss, and its derivative with respect to each point's velocity.
  w.error = w.nu - observed;
  double loss = 0.0;
  for (Eigen::Index c = 0; c < B * K; ++c)
    for (int i = 0; i < 3; ++i) loss += static_cast<double>(weight(i, c)) * w.error(i, c) * w.error(i, c);
  const S twice = static_cast<S>(2.0 / batch.count);
  w.error.array() *= twice * weight.array();

  // Backpropagation through time: lambda is the derivative with respect to the state at k.
  w.lambda_nu = w.error.rightCols(B);
  w.lambda_psi.setZero(1, B);
  for (Eigen::Index k = steps - 1; k >= 0; --k) {
    const Eigen::Index c = k * B;
    auto delta = w.dynamics.delta[net.hidden_layers].middleCols(c, B);
    for (Eigen::Index b = 0; b < B; ++b) delta.col(b) = model.dt * output_scale.cwiseProduct(w.lambda_nu.col(b));
    backward_columns(net, parameters, w.dynamics, c, B, &w.input_derivative);
    for (Eigen::Index b = 0; b < B; ++b) w.input_derivative.col(b) = w.input_derivative.col(b).cwiseProduct(inverse_sd);
    if (has_base) pull_back_through_base(k, B, model.dt, w);
    w.lambda_nu += w.input_derivative.topRows(3) + w.error.middleCols(c, B);
    if (!has_base) w.lambda_nu.row(2) += model.dt * w.lambda_psi;
    if (model.wind) {
      const auto dx = w.input_derivative.row(wind_row).array(), dy = w.input_derivative.row(wind_row + 1).array();
      const auto cosine = w.cosine.middleCols(c, B).array(), sine = w.sine.middleCols(c, B).array();
      const auto x = true_wind.middleCols(c, B).row(0).array(), y = true_wind.middleCols(c, B).row(1).array();
      w.lambda_nu.row(0).array() += dx;
      w.lambda_nu.row(1).array() += dy;
      w.lambda_psi.array() += dx * (cosine * y - sine * x) - dy * (cosine * x + sine * y);
    }
  }
  parameter_gradient(net, w.inputs, w.dynamics, gradient);

  if (start.outputs > 0) {
    auto& delta = w.initial_state.delta[start.hidden_layers];
    for (Eigen::Index b = 0; b < B; ++b) {
      const S mask = batch.initial_state_mask[b];
      delta(0, b) = delta(1, b) = S(0);  // the position is not in the loss
      delta(2, b) = mask * model.initial_state_scale[2] * w.lambda_psi(0, b);
      for (int i = 0; i < 3; ++i) delta(3 + i, b) = mask * model.initial_state_scale[3 + i] * w.lambda_nu(i, b);
    }
    backward_columns<S>(start, start_parameters, w.initial_state, 0, B, nullptr);
    parameter_gradient(start, start_inputs, w.initial_state, gradient + offset_of(net, (net.hidden_layers + 1)));
  }
  return loss / batch.count;
}

template <typename S>
void reference_forward(const NetworkShape& shape, const S* parameters, const S* inputs, int n, S* outputs) {
  NetworkWork<S> work;
  work.resize(shape, n, false);
  const ConstMatrix<S> columns(inputs, shape.inputs, n);
  forward_columns(shape, parameters, columns, work, 0, n);
  Eigen::Map<Matrix<S>>(outputs, shape.outputs, n) = work.output;
}

template double reference_loss_and_gradient(const RolloutModel<float>&, const RolloutBatch<float>&, const float*,
                                            float*);
template double reference_loss_and_gradient(const RolloutModel<double>&, const RolloutBatch<double>&, const double*,
                                            double*);
template void reference_forward(const NetworkShape&, const float*, const float*, int, float*);
template void reference_forward(const NetworkShape&, const double*, const double*, int, double*);

}  // namespace leeway::test
