#pragma once

#include "nn/workspace.hpp"

/// A network forwards and backwards for a block of lanes. For rollout_kernel.cpp alone, as vector.hpp.
namespace leeway::nn::LEEWAY_KERNEL {
namespace {

// finish(position, sum) for the rows of a layer's weights * in + bias, or of its transposed weights * in.
template <int C, typename S, typename Finish>
void layer_product(const typename Network<S>::Layer& layer, bool transposed, const S* in, const Finish& finish) {
  const int rows = transposed ? layer.inputs : layer.outputs, cols = transposed ? layer.outputs : layer.inputs;
  const S* bias = transposed ? nullptr : layer.bias.at(0);
  product<C>((transposed ? layer.transposed_panels : layer.panels).at(0), rows, cols, bias, in, finish);
}

// Evaluates a network for [input][lane]; hidden outputs go to `step` of the work.
template <int C, typename S>
void forward_step(const Network<S>& network, const S* in, long step, NetworkWork<S>& work) {
  const NetworkShape& shape = network.shape;
  const long at = step * shape.hidden_units * C * kWidth<S>;
  for (int l = 0; l <= shape.hidden_layers; ++l) {
    const auto& layer = network.layers[l];
    if (l < shape.hidden_layers) {
      S* out = work.hidden[l].at(at);
      layer_product<C, S>(layer, false, in,
                          [out](int position, Vector<S> sum) { store<S>(out + position, tanh(sum)); });
      in = out;
    } else {
      S* out = work.output.at(0);
      layer_product<C, S>(layer, false, in, [out](int position, Vector<S> sum) { store<S>(out + position, sum); });
    }
  }
}

// From work.output_delta to the derivative by the inputs [input][lane], unless that is nullptr. The deltas of all
// layers become samples of the chunk; at its first step (step is a multiple of `chunk`) the weight gradient is added.
//   inputs  [step][input][lane]
template <int C, typename S>
void backward_step(const Network<S>& network, const S* inputs, int step, int steps, NetworkWork<S>& work,
                   S* input_derivative) {
  constexpr int L = C * kWidth<S>, chunk = kChunkSteps<L>;
  const NetworkShape& shape = network.shape;
  const long hidden_step = static_cast<long>(shape.hidden_units) * L;
  const int begin = step / chunk * chunk;
  const S* delta = work.output_delta.at(0);
  for (int l = shape.hidden_layers; l >= 0; --l) {
    const auto& layer = network.layers[l];
    append_samples<C>(delta, layer.whole_outputs, step - begin, kChunkSamples, work.groups[l].at(0));
    if (l == 0) {
      if (input_derivative != nullptr)
        layer_product<C, S>(layer, true, delta,
                            [=](int position, Vector<S> sum) { store<S>(input_derivative + position, sum); });
    } else {
      const S* h = work.hidden[l - 1].at(step * hidden_step);
      S* below = work.delta[l % 2].at(0);
      layer_product<C, S>(layer, true, delta, [=](int position, Vector<S> sum) {
        const Vector<S> tanh = load(h + position);
        store<S>(below + position, sum * multiply_add<S>(-tanh, tanh, broadcast(S(1))));
      });
      delta = below;
    }
  }
  if (step != begin) return;
  const int size = steps - begin < chunk ? steps - begin : chunk;
  for (int l = 0; l <= shape.hidden_layers; ++l) {
    const auto& layer = network.layers[l];
    const S* in =
        l == 0 ? inputs + static_cast<long>(begin) * shape.inputs * L : work.hidden[l - 1].at(begin * hidden_step);
    const long in_step = static_cast<long>(layer.inputs) * L;
    S* gradient = work.gradient[l].at(0);
    add_bias_gradient<S>(work.groups[l].at(0), kChunkSamples, size * L, layer.whole_outputs,
                         gradient + static_cast<long>(layer.inputs) * layer.whole_outputs);
    add_weight_gradient<C>(work.groups[l].at(0), static_cast<long>(kChunkSamples), size, layer.whole_outputs, in,
                           layer.inputs, in_step, gradient);
  }
}

}  // namespace
}  // namespace leeway::nn::LEEWAY_KERNEL
