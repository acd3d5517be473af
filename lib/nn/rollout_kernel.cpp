// The hot loops, compiled once per instruction set with LEEWAY_KERNEL naming the namespace (lib/CMakeLists.txt).
// Everything but the table at the end has internal linkage, and nothing from elsewhere may be instantiated here: the
// linker cannot mix instruction sets then (tests/nn/kernel_symbols.cmake).
#include <new>

#include "nn/products.hpp"
#include "nn/rollout.hpp"
#ifdef LEEWAY_TILES
#include "nn/tiles.hpp"
#endif

#define LEEWAY_TEXT(a) #a
#define LEEWAY_TEXT_EXPANDED(a) LEEWAY_TEXT(a)

namespace leeway::nn::LEEWAY_KERNEL {
namespace {

constexpr int kMostLayers = 16;

/// Samples whose weight gradients are taken together, while they are in the cache.
constexpr int kChunkSamples = 128;

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

int inputs_of(const NetworkShape& s, int layer) { return layer == 0 ? s.inputs : s.hidden_units; }
int outputs_of(const NetworkShape& s, int layer) { return layer == s.hidden_layers ? s.outputs : s.hidden_units; }

// Position of a layer's weights in the parameters; its biases follow them.
long offset_of(const NetworkShape& s, int layer) {
  long offset = 0;
  for (int l = 0; l < layer; ++l) offset += static_cast<long>(outputs_of(s, l)) * (inputs_of(s, l) + 1);
  return offset;
}

// Layers whose products are made in tiles: in training alone, where all lanes of a block are computed in the same way.
bool in_tiles([[maybe_unused]] int inputs, [[maybe_unused]] int outputs) {
#ifdef LEEWAY_TILES
  return fits_tiles(inputs, outputs);
#else
  return false;
#endif
}

// The weights of a network as the products want them.
template <typename S>
struct Network {
  struct Layer {
    int inputs = 0, outputs = 0, whole_outputs = 0;  // the last one rounded up to whole vectors
    Buffer<S> panels, bias;
    Buffer<S> transposed_panels;  // for gradients
    Buffer<S> columns;            // for few columns: [inputs][whole_outputs]
    bool tiled = false;           // then these instead of the panels:
    Buffer<int> tiles, transposed_tiles;
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
      layer.tiled = gradients && in_tiles(layer.inputs, layer.outputs);
#ifdef LEEWAY_TILES
      if (layer.tiled) {
        layer.tiles.reserve(size);
        pack_tiles(weights, layer.outputs, layer.inputs, 1, layer.outputs, layer.tiles.at(0));
        layer.transposed_tiles.reserve(size);
        pack_tiles(weights, layer.inputs, layer.outputs, layer.outputs, 1, layer.transposed_tiles.at(0));
        continue;
      }
#endif
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

  Buffer<int> delta_tiles[kMostLayers + 1];  // the same for layers in tiles
  Buffer<int> scratch;                       // what tiles are made of

  void reserve(const Network<S>& network, long steps, int lanes) {
    const NetworkShape& shape = network.shape;
    const int whole_units = whole_vectors<S>(shape.hidden_units), whole_outputs = whole_vectors<S>(shape.outputs);
    for (int l = 0; l < shape.hidden_layers; ++l) hidden[l].reserve(steps * shape.hidden_units * lanes);
    output.reserve(static_cast<long>(shape.outputs) * lanes);
    for (Buffer<S>& d : delta) d.reserve(static_cast<long>(whole_units) * lanes);
    output_delta.reserve(static_cast<long>(whole_outputs) * lanes);
    for (int l = 0; l <= shape.hidden_layers; ++l)
      groups[l].reserve(static_cast<long>(network.layers[l].whole_outputs) * kChunkSamples);
    for (int l = 0; l <= shape.hidden_layers; ++l)
      if (network.layers[l].tiled) {
        delta_tiles[l].reserve(static_cast<long>(network.layers[l].outputs) * kChunkSamples);
        const long most = shape.hidden_units > shape.outputs ? shape.hidden_units : shape.outputs;
        scratch.reserve((network.layers[l].inputs + most) * kChunkSamples + 1024);
      }
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

// finish(position, sum) for the rows of a layer's weights * in + bias, or of its transposed weights * in.
template <int C, typename S, typename Finish>
void layer_product(const typename Network<S>::Layer& layer, bool transposed, const S* in,
                   [[maybe_unused]] NetworkWork<S>& work, const Finish& finish) {
  const int rows = transposed ? layer.inputs : layer.outputs, cols = transposed ? layer.outputs : layer.inputs;
  const S* bias = transposed ? nullptr : layer.bias.at(0);
#ifdef LEEWAY_TILES
  if (layer.tiled)
    return tile_product<C>((transposed ? layer.transposed_tiles : layer.tiles).at(0), rows, cols, bias, in,
                           work.scratch.at(0), finish);
#endif
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
      layer_product<C, S>(layer, false, in, work,
                          [out](int position, Vector<S> sum) { store<S>(out + position, tanh(sum)); });
      in = out;
    } else {
      S* out = work.output.at(0);
      layer_product<C, S>(layer, false, in, work,
                          [out](int position, Vector<S> sum) { store<S>(out + position, sum); });
    }
  }
}

// From work.output_delta to the derivative by the inputs [input][lane], unless that is nullptr. The deltas of all
// layers become samples of the chunk; at its first step (step is a multiple of `chunk`) the weight gradient is added.
//   inputs  [step][input][lane]
template <int C, typename S>
void backward_step(const Network<S>& network, const S* inputs, int step, int steps, NetworkWork<S>& work,
                   S* input_derivative) {
  constexpr int L = C * kWidth<S>, chunk = kChunkSamples / L;
  const NetworkShape& shape = network.shape;
  const long hidden_step = static_cast<long>(shape.hidden_units) * L;
  const int begin = step / chunk * chunk;
  const S* delta = work.output_delta.at(0);
  for (int l = shape.hidden_layers; l >= 0; --l) {
    const auto& layer = network.layers[l];
    append_samples<C>(delta, layer.whole_outputs, step - begin, kChunkSamples, work.groups[l].at(0));
#ifdef LEEWAY_TILES
    if constexpr (C == 2)
      if (layer.tiled) append_sample_tiles(delta, layer.outputs, step - begin, chunk, work.delta_tiles[l].at(0));
#endif
    if (l == 0) {
      if (input_derivative != nullptr)
        layer_product<C, S>(layer, true, delta, work,
                            [=](int position, Vector<S> sum) { store<S>(input_derivative + position, sum); });
    } else {
      const S* h = work.hidden[l - 1].at(step * hidden_step);
      S* below = work.delta[l % 2].at(0);
      layer_product<C, S>(layer, true, delta, work, [=](int position, Vector<S> sum) {
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
#ifdef LEEWAY_TILES
    // A row of a tile is 32 samples: narrower blocks stay with the vectors.
    if constexpr (C == 2)
      if (layer.tiled) {
        add_tile_gradient(work.delta_tiles[l].at(0), chunk, size, layer.outputs, in, layer.inputs, in_step,
                          work.scratch.at(0), gradient);
        continue;
      }
#endif
    add_weight_gradient<C>(work.groups[l].at(0), static_cast<long>(kChunkSamples), size, layer.whole_outputs, in,
                           layer.inputs, in_step, gradient);
  }
}

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
    const int left = batch.windows - first, windows = left < 2 * kWidth<S> ? left : 2 * kWidth<S>;
    loss += windows > kWidth<S> ? BlockRollout<2, S>(w, model, batch, first, windows).run()
                                : BlockRollout<1, S>(w, model, batch, first, windows).run();
    first += windows;
  }
  w.dynamics_work.copy_gradient(w.dynamics, gradient);
  if (has_start) w.initial_state_work.copy_gradient(w.initial_state, gradient + start_offset);
  return loss / batch.count;
}

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

template <typename S>
void* make_network(const NetworkShape& shape, const S* parameters) {
  auto* network = new Network<S>;
  network->pack(shape, parameters, false);
  return network;
}

template <typename S>
void free_network(void* network) {
  delete static_cast<Network<S>*>(network);
}

template <typename S>
void accelerations(void* memory, const RolloutModel<S>& model, const void* network, const S* inputs, int n, S* result) {
  evaluate<S>(memory, *static_cast<const Network<S>*>(network),
              {model.input_mean, model.input_inverse_sd, model.output_offset, model.output_scale}, inputs, n, result);
}

template <typename S>
void forward(void* memory, const void* network, const S* inputs, int n, S* outputs) {
  evaluate<S>(memory, *static_cast<const Network<S>*>(network), {}, inputs, n, outputs);
}

template <typename S>
void tanh_of(const S* x, std::size_t n, S* result) {
  Vector<S> v{};
  for (; n >= kWidth<S>; n -= kWidth<S>, x += kWidth<S>, result += kWidth<S>) {
    __builtin_memcpy(&v, x, sizeof v);
    v = tanh(v);
    __builtin_memcpy(result, &v, sizeof v);
  }
  __builtin_memcpy(&v, x, n * sizeof(S));
  v = tanh(v);
  __builtin_memcpy(result, &v, n * sizeof(S));
}

template <typename S>
S square_root(S x) {
  if constexpr (sizeof(S) == sizeof(float)) return __builtin_sqrtf(x);
  return static_cast<S>(__builtin_sqrt(x));
}

template <typename S>
void adam(const AdamSettings& settings, long step, std::size_t n, const S* gradient, S* parameters, S* m, S* v) {
  const double count = static_cast<double>(step);
  const S rate = static_cast<S>(settings.learning_rate / (1.0 - __builtin_pow(settings.beta1, count)));
  const S root = static_cast<S>(1.0 / __builtin_sqrt(1.0 - __builtin_pow(settings.beta2, count)));
  const S b1 = static_cast<S>(settings.beta1), b2 = static_cast<S>(settings.beta2);
  const S epsilon = static_cast<S>(settings.epsilon);
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    const S g = gradient[i];
    m[i] = b1 * m[i] + (S(1) - b1) * g;
    v[i] = b2 * v[i] + (S(1) - b2) * (g * g);
    parameters[i] -= rate * m[i] / (square_root(v[i]) * root + epsilon);
  }
}

template <typename S>
double multiply_adds(long repeats) {
  constexpr int kChains = 10;  // enough to hide the latency, few enough for 16 registers
  Vector<S> sums[kChains];
  const Vector<S> factor = broadcast(S(0.999)), term = broadcast(S(0.001));
#pragma GCC unroll 10
  for (int i = 0; i < kChains; ++i) sums[i] = broadcast(S(i));
  for (long n = 0; n < repeats; ++n)
#pragma GCC unroll 10
    for (int i = 0; i < kChains; ++i) sums[i] = multiply_add<S>(sums[i], factor, term);
  Vector<S> total{};
#pragma GCC unroll 10
  for (int i = 0; i < kChains; ++i) total += sums[i];
  const volatile S keep = total[0];  // the sums must be computed
  static_cast<void>(keep);
  return 2.0 * kChains * kWidth<S> * static_cast<double>(repeats);
}

template <typename S>
void* make_workspace() {
  return new Work<S>;
}

template <typename S>
void free_workspace(void* memory) {
  delete static_cast<Work<S>*>(memory);
}

template <typename S>
constexpr Kernels<S> kTable{LEEWAY_TEXT_EXPANDED(LEEWAY_KERNEL),
                            &make_workspace<S>,
                            &free_workspace<S>,
                            &make_network<S>,
                            &free_network<S>,
                            &loss_and_gradient<S>,
                            &accelerations<S>,
                            &forward<S>,
                            &adam<S>,
                            &tanh_of<S>,
                            &multiply_adds<S>};

}  // namespace

const Kernels<float>& kernels_float();
const Kernels<float>& kernels_float() { return kTable<float>; }

#ifdef LEEWAY_KERNEL_DOUBLE
const Kernels<double>& kernels_double();
const Kernels<double>& kernels_double() { return kTable<double>; }
#endif

}  // namespace leeway::nn::LEEWAY_KERNEL
