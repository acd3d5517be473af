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

// A rollout and its loss as the equations say, all windows side by side.
template <typename S>
class ReferenceRollout {
 public:
  ReferenceRollout(const RolloutModel<S>& model, const RolloutBatch<S>& batch, const S* parameters)
      : model_(model),
        batch_(batch),
        parameters_(parameters),
        start_parameters_(parameters + offset_of(model.dynamics, model.dynamics.hidden_layers + 1)),
        B_(batch.windows),
        K_(batch.points),
        steps_(batch.points - 1),
        wind_row_(3 + model.controls),
        has_base_(batch.base.evaluate != nullptr),
        has_start_(model.initial_state.outputs > 0),
        observed_(batch.nu_observed, 3, B_ * K_),
        weight_(batch.weight, 3, B_ * K_),
        controls_(batch.controls, model.controls, B_ * K_),
        true_wind_(batch.true_wind, 2, model.wind ? B_ * K_ : 0),
        start_inputs_(batch.initial_state_inputs, model.initial_state.inputs, has_start_ ? B_ : 0),
        mean_(model.input_mean, model.dynamics.inputs),
        inverse_sd_(model.input_inverse_sd, model.dynamics.inputs),
        output_offset_(model.output_offset, 3),
        output_scale_(model.output_scale, 3) {
    w_.dynamics.resize(model.dynamics, B_ * steps_, true);
    w_.inputs.resize(model.dynamics.inputs, B_ * steps_);
    w_.nu.resize(3, B_ * K_);
    w_.psi.resize(1, B_ * K_);
    w_.cosine.resize(1, B_ * K_);
    w_.sine.resize(1, B_ * K_);
    if (has_base_) {
      w_.base_rates.resize(4, B_);
      w_.base_derivatives.resize(4, 4 * B_ * steps_);
    }
  }

  double loss_and_gradient(S* gradient) {
    start();
    for (Eigen::Index k = 0; k < steps_; ++k) step(k);
    const double loss = compare();
    w_.lambda_nu = w_.error.rightCols(B_);
    w_.lambda_psi.setZero(1, B_);
    for (Eigen::Index k = steps_ - 1; k >= 0; --k) step_back(k);
    parameter_gradient(model_.dynamics, w_.inputs, w_.dynamics, gradient);
    if (has_start_) start_back(gradient + (start_parameters_ - parameters_));
    return loss / batch_.count;
  }

 private:
  // The observed state plus the correction of the initial-state network.
  void start() {
    w_.nu.leftCols(B_) = observed_.leftCols(B_);
    w_.psi.leftCols(B_) = Eigen::Map<const Eigen::Matrix<S, 1, Eigen::Dynamic>>(batch_.psi_initial, B_);
    if (!has_start_) return;
    w_.initial_state.resize(model_.initial_state, B_, true);
    forward_columns(model_.initial_state, start_parameters_, start_inputs_, w_.initial_state, 0, B_);
    for (Eigen::Index b = 0; b < B_; ++b) {
      const S mask = batch_.initial_state_mask[b];
      w_.psi(0, b) += mask * model_.initial_state_scale[2] * w_.initial_state.output(2, b);
      for (int i = 0; i < 3; ++i)
        w_.nu(i, b) += mask * model_.initial_state_scale[3 + i] * w_.initial_state.output(3 + i, b);
    }
  }

  // Euler from k to k + 1 with the inputs of k.
  void step(Eigen::Index k) {
    const Eigen::Index c = k * B_;
    auto inputs = w_.inputs.middleCols(c, B_);
    const auto nu = w_.nu.middleCols(c, B_);
    inputs.topRows(3) = nu;
    inputs.middleRows(3, model_.controls) = controls_.middleCols(c, B_);
    if (model_.wind) {
      auto cosine = w_.cosine.middleCols(c, B_).array();
      auto sine = w_.sine.middleCols(c, B_).array();
      cosine = w_.psi.middleCols(c, B_).array().cos();
      sine = w_.psi.middleCols(c, B_).array().sin();
      const auto x = true_wind_.middleCols(c, B_).row(0).array(), y = true_wind_.middleCols(c, B_).row(1).array();
      inputs.row(wind_row_).array() = cosine * x + sine * y + nu.row(0).array();
      inputs.row(wind_row_ + 1).array() = cosine * y - sine * x + nu.row(1).array();
    }
    for (Eigen::Index b = 0; b < B_; ++b) inputs.col(b) = (inputs.col(b) - mean_).cwiseProduct(inverse_sd_);
    forward_columns(model_.dynamics, parameters_, w_.inputs, w_.dynamics, c, B_);
    for (Eigen::Index b = 0; b < B_; ++b)
      w_.nu.col(c + B_ + b) =
          w_.nu.col(c + b) + model_.dt * (output_offset_ + output_scale_.cwiseProduct(w_.dynamics.output.col(c + b)));
    if (has_base_)
      add_base(batch_.base, static_cast<int>(k), B_, model_.dt, w_);
    else
      w_.psi.middleCols(c + B_, B_) = w_.psi.middleCols(c, B_) + model_.dt * nu.row(2);
  }

  // The loss; its derivatives by each point's velocity go to w_.error.
  double compare() {
    w_.error = w_.nu - observed_;
    double loss = 0.0;
    for (Eigen::Index c = 0; c < B_ * K_; ++c)
      for (int i = 0; i < 3; ++i) loss += static_cast<double>(weight_(i, c)) * w_.error(i, c) * w_.error(i, c);
    const S twice = static_cast<S>(2.0 / batch_.count);
    w_.error.array() *= twice * weight_.array();
    return loss;
  }

  // lambda, the loss derivative by the state, from k + 1 to k.
  void step_back(Eigen::Index k) {
    const Eigen::Index c = k * B_;
    auto delta = w_.dynamics.delta[model_.dynamics.hidden_layers].middleCols(c, B_);
    for (Eigen::Index b = 0; b < B_; ++b) delta.col(b) = model_.dt * output_scale_.cwiseProduct(w_.lambda_nu.col(b));
    backward_columns(model_.dynamics, parameters_, w_.dynamics, c, B_, &w_.input_derivative);
    for (Eigen::Index b = 0; b < B_; ++b)
      w_.input_derivative.col(b) = w_.input_derivative.col(b).cwiseProduct(inverse_sd_);
    if (has_base_) pull_back_through_base(k, B_, model_.dt, w_);
    w_.lambda_nu += w_.input_derivative.topRows(3) + w_.error.middleCols(c, B_);
    if (!has_base_) w_.lambda_nu.row(2) += model_.dt * w_.lambda_psi;
    if (model_.wind) {
      const auto dx = w_.input_derivative.row(wind_row_).array(), dy = w_.input_derivative.row(wind_row_ + 1).array();
      const auto cosine = w_.cosine.middleCols(c, B_).array(), sine = w_.sine.middleCols(c, B_).array();
      const auto x = true_wind_.middleCols(c, B_).row(0).array(), y = true_wind_.middleCols(c, B_).row(1).array();
      w_.lambda_nu.row(0).array() += dx;
      w_.lambda_nu.row(1).array() += dy;
      w_.lambda_psi.array() += dx * (cosine * y - sine * x) - dy * (cosine * x + sine * y);
    }
  }

  void start_back(S* gradient) {
    auto& delta = w_.initial_state.delta[model_.initial_state.hidden_layers];
    for (Eigen::Index b = 0; b < B_; ++b) {
      const S mask = batch_.initial_state_mask[b];
      delta(0, b) = delta(1, b) = S(0);  // the position is not in the loss
      delta(2, b) = mask * model_.initial_state_scale[2] * w_.lambda_psi(0, b);
      for (int i = 0; i < 3; ++i) delta(3 + i, b) = mask * model_.initial_state_scale[3 + i] * w_.lambda_nu(i, b);
    }
    backward_columns<S>(model_.initial_state, start_parameters_, w_.initial_state, 0, B_, nullptr);
    parameter_gradient(model_.initial_state, start_inputs_, w_.initial_state, gradient);
  }

  const RolloutModel<S>& model_;
  const RolloutBatch<S>& batch_;
  const S *parameters_, *start_parameters_;
  const Eigen::Index B_, K_, steps_;  // windows, points
  const int wind_row_;
  const bool has_base_, has_start_;
  const ConstMatrix<S> observed_, weight_, controls_, true_wind_, start_inputs_;
  const Eigen::Map<const Vector<S>> mean_, inverse_sd_, output_offset_, output_scale_;
  Work<S> w_;
};

}  // namespace

template <typename S>
double reference_loss_and_gradient(const RolloutModel<S>& model, const RolloutBatch<S>& batch, const S* parameters,
                                   S* gradient) {
  return ReferenceRollout<S>(model, batch, parameters).loss_and_gradient(gradient);
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
