#pragma once

#include <new>

#include "nn/products.hpp"
#include "nn/rollout.hpp"

/// Memory of a kernel: the weights of a network as the products want them, and what a rollout keeps of each step.
/// For rollout_kernel.cpp alone, as vector.hpp.
namespace leeway::nn::LEEWAY_KERNEL {
namespace {

constexpr int kMostLayers = 16;

/// Lanes of the largest block of a training. The same where vectors have 8 and 16 lanes, as the order of a gradient's
/// sums is: block by block, in it chunk by chunk of steps from the last one, in that step by step and lane by lane.
#if defined(__FMA__)
constexpr int kBlockLanes = 32;
#else
constexpr int kBlockLanes = 2 * kWidth<float>;
#endif

/// Samples whose weight gradients are taken together, while they are in the cache.
constexpr int kChunkSamples = 128;

/// Steps of a chunk for a block of L lanes; the same for 8 lanes, which some vectors have, and 16, which all blocks
/// fit.
template <int L>
constexpr int kChunkSteps = kChunkSamples / (L < 16 ? 16 : L);

constexpr std::align_val_t kAlignment{64};

// Aligned memory that grows; new memory is zero.
template <typename S>
class Buffer {
 public:
  Buffer() = default;
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { ::operator delete(data_, kAlignment); }

  void reserve(long size) {
    if (size <= size_) return;
    ::operator delete(data_, kAlignment);
    data_ = nullptr;
    size_ = 0;
    data_ = static_cast<S*>(::operator new(static_cast<std::size_t>(size) * sizeof(S), kAlignment));
    size_ = size;
    clear(size);
  }
  void clear(long size) { __builtin_memset(data_, 0, static_cast<std::size_t>(size) * sizeof(S)); }
  S* at(long i) { return data_ + i; }
  const S* at(long i) const { return data_ + i; }

 private:
  S* data_ = nullptr;
  long size_ = 0;
};

template <typename S>
int whole_vectors(int size) {
  return (size + kWidth<S> - 1) / kWidth<S> * kWidth<S>;
}

inline int inputs_of(const NetworkShape& s, int layer) { return layer == 0 ? s.inputs : s.hidden_units; }
inline int outputs_of(const NetworkShape& s, int layer) {
  return layer == s.hidden_layers ? s.outputs : s.hidden_units;
}

// Position of a layer's weights in the parameters; its biases follow them.
inline long offset_of(const NetworkShape& s, int layer) {
  long offset = 0;
  for (int l = 0; l < layer; ++l) offset += static_cast<long>(outputs_of(s, l)) * (inputs_of(s, l) + 1);
  return offset;
}

// The weights of a network as the products want them.
template <typename S>
struct Network {
  struct Layer {
    int inputs = 0, outputs = 0, whole_outputs = 0;  // the last one rounded up to whole vectors
    Buffer<S> panels, bias;
    Buffer<S> transposed_panels;  // for gradients
    Buffer<S> columns;            // for few columns: [inputs][whole_outputs]
  };

  NetworkShape shape;
  Layer layers[kMostLayers + 1];

  void pack(const NetworkShape& network, const S* parameters, bool gradients) {
    shape = network;
    if (shape.outputs == 0) return;
    for (int l = 0; l <= shape.hidden_layers; ++l) {
      Layer& layer = layers[l];
      layer.inputs = inputs_of(shape, l);
      layer.outputs = outputs_of(shape, l);
      layer.whole_outputs = whole_vectors<S>(layer.outputs);
      const long size = static_cast<long>(layer.inputs) * layer.outputs;
      const S* weights = parameters + offset_of(shape, l);
      layer.bias.reserve(layer.whole_outputs);
      __builtin_memcpy(layer.bias.at(0), weights + size, static_cast<std::size_t>(layer.outputs) * sizeof(S));
      layer.panels.reserve(size);
      pack_panels(weights, layer.outputs, layer.inputs, 1, layer.outputs, layer.panels.at(0));
      if (gradients) {
        layer.transposed_panels.reserve(size);
        pack_panels(weights, layer.inputs, layer.outputs, layer.outputs, 1, layer.transposed_panels.at(0));
        continue;
      }
      layer.columns.reserve(static_cast<long>(layer.inputs) * layer.whole_outputs);
      for (int k = 0; k < layer.inputs; ++k)
        __builtin_memcpy(layer.columns.at(static_cast<long>(k) * layer.whole_outputs),
                         weights + static_cast<long>(k) * layer.outputs,
                         static_cast<std::size_t>(layer.outputs) * sizeof(S));
    }
  }
};

// What backpropagation needs to know of one network and one block of lanes, and its gradient over all blocks.
template <typename S>
struct NetworkWork {
  Buffer<S> hidden[kMostLayers];        // tanh outputs [step][unit][lane]
  Buffer<S> output;                     // [output][lane]
  Buffer<S> delta[2];                   // loss derivatives before tanh, of two layers in turn
  Buffer<S> output_delta;               // [output][lane]
  Buffer<S> groups[kMostLayers + 1];    // the deltas of a chunk of steps as samples, for the weight gradient
  Buffer<S> gradient[kMostLayers + 1];  // [inputs + 1][whole outputs]

  void reserve(const Network<S>& network, long steps, int lanes) {
    const NetworkShape& shape = network.shape;
    const int whole_units = whole_vectors<S>(shape.hidden_units), whole_outputs = whole_vectors<S>(shape.outputs);
    for (int l = 0; l < shape.hidden_layers; ++l) hidden[l].reserve(steps * shape.hidden_units * lanes);
    output.reserve(static_cast<long>(shape.outputs) * lanes);
    for (Buffer<S>& d : delta) d.reserve(static_cast<long>(whole_units) * lanes);
    output_delta.reserve(static_cast<long>(whole_outputs) * lanes);
    for (int l = 0; l <= shape.hidden_layers; ++l)
      groups[l].reserve(static_cast<long>(network.layers[l].whole_outputs) * kChunkSamples);
  }

  void clear_gradient(const Network<S>& network) {
    for (int l = 0; l <= network.shape.hidden_layers; ++l) {
      const long size = static_cast<long>(network.layers[l].inputs + 1) * network.layers[l].whole_outputs;
      gradient[l].reserve(size);
      gradient[l].clear(size);
    }
  }

  void copy_gradient(const Network<S>& network, S* to) const {
    for (int l = 0; l <= network.shape.hidden_layers; ++l) {
      const typename Network<S>::Layer& layer = network.layers[l];
      for (int k = 0; k <= layer.inputs; ++k, to += layer.outputs)
        __builtin_memcpy(to, gradient[l].at(static_cast<long>(k) * layer.whole_outputs),
                         static_cast<std::size_t>(layer.outputs) * sizeof(S));
    }
  }
};

template <typename S>
struct Work {
  Network<S> dynamics, initial_state;
  NetworkWork<S> dynamics_work, initial_state_work;
  Buffer<S> inputs, start_inputs;  // standardized, [step][input][lane]
  Buffer<S> nu, error;             // [point][3][lane]
  Buffer<S> psi;                   // [point][lane]
  Buffer<S> wind_x, wind_y;        // true wind in ship axes [step][lane]
  Buffer<S> lambda, input_derivative;
  Buffer<S> base_nu, base_psi, base_rates, base_derivatives;  // as the base wants them
};

}  // namespace
}  // namespace leeway::nn::LEEWAY_KERNEL
