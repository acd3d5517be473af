#pragma once

#include "nn/propagation.hpp"

/// A network for as many columns as there are. For rollout_kernel.cpp alone, as vector.hpp.
namespace leeway::nn::LEEWAY_KERNEL {
namespace {

// What is done with raw inputs before a network and with its outputs after it.
template <typename S>
struct Scaling {
  const S *mean, *inverse_sd, *offset, *scale;
  S input(int j, S x) const { return mean == nullptr ? x : (x - mean[j]) * inverse_sd[j]; }
  S output(int i, S y) const { return mean == nullptr ? y : offset[i] + scale[i] * y; }
};

// A block of at most C vectors of lanes.
template <int C, typename S>
void evaluate_block(Work<S>& w, const Network<S>& network, const Scaling<S>& scaling, const S* inputs, int n,
                    S* outputs) {
  constexpr int L = C * kWidth<S>;
  const NetworkShape& shape = network.shape;
  w.inputs.reserve(static_cast<long>(shape.inputs) * L);
  for (int j = 0; j < shape.inputs; ++j)
    for (int b = 0; b < L; ++b)
      w.inputs.at(static_cast<long>(j) * L)[b] = b < n ? scaling.input(j, inputs[b * shape.inputs + j]) : S(0);
  w.dynamics_work.reserve(network, 1, L);
  forward_step<C>(network, w.inputs.at(0), 0, w.dynamics_work);
  for (int b = 0; b < n; ++b)
    for (int i = 0; i < shape.outputs; ++i)
      outputs[b * shape.outputs + i] = scaling.output(i, w.dynamics_work.output.at(0)[i * L + b]);
}

// Columns that fill at most half a vector of lanes: the features are the vector.
template <typename S>
void evaluate_few(Work<S>& w, const Network<S>& network, const Scaling<S>& scaling, const S* inputs, int n,
                  S* outputs) {
  constexpr int most = kWidth<S> / 2;
  const NetworkShape& shape = network.shape;
  w.inputs.reserve(static_cast<long>(shape.inputs) * most);
  for (int b = 0; b < n; ++b)
    for (int j = 0; j < shape.inputs; ++j)
      w.inputs.at(0)[b * shape.inputs + j] = scaling.input(j, inputs[b * shape.inputs + j]);
  const S* in = w.inputs.at(0);
  int in_step = shape.inputs;
  for (int l = 0; l <= shape.hidden_layers; ++l) {
    const auto& layer = network.layers[l];
    const bool last = l == shape.hidden_layers;
    Buffer<S>& buffer = last ? w.dynamics_work.output : w.dynamics_work.hidden[l];
    const int out_step = layer.whole_outputs;
    buffer.reserve(static_cast<long>(out_step) * most);
    S* out = buffer.at(0);
    few_columns_product<most>(
        n, layer.columns.at(0), out_step, layer.inputs, layer.bias.at(0), in, in_step,
        [=](int column, int row, Vector<S> sum) { store<S>(out + column * out_step + row, last ? sum : tanh(sum)); });
    in = out;
    in_step = out_step;
  }
  for (int b = 0; b < n; ++b)
    for (int i = 0; i < shape.outputs; ++i) outputs[b * shape.outputs + i] = scaling.output(i, in[b * in_step + i]);
}

template <typename S>
void evaluate(void* memory, const Network<S>& network, const Scaling<S>& scaling, const S* inputs, int n, S* outputs) {
  constexpr int W = kWidth<S>;
  Work<S>& w = *static_cast<Work<S>*>(memory);
  while (n > 0) {
    int done = n;
    if (n > W + W / 2) {
      done = n < 2 * W ? n : 2 * W;
      evaluate_block<2>(w, network, scaling, inputs, done, outputs);
    } else if (n > W / 2) {
      done = n < W ? n : W;
      evaluate_block<1>(w, network, scaling, inputs, done, outputs);
    } else {
      evaluate_few(w, network, scaling, inputs, done, outputs);
    }
    inputs += static_cast<long>(done) * network.shape.inputs;
    outputs += static_cast<long>(done) * network.shape.outputs;
    n -= done;
  }
}

}  // namespace
}  // namespace leeway::nn::LEEWAY_KERNEL
