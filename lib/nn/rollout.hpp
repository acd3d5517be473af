#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "core/random.hpp"

/// The learned equation of motion and the loss of its rollout.
///
/// Accelerations come from a feedforward network with tanh units, nu' = offset + scale * net((inputs - mean) / sd),
/// inputs = (u, v_m, r, actuators, apparent wind x and y). A rollout starts from the observed state plus the
/// correction of a second network, steps by Euler, and is compared with the observed velocities at each point. Known
/// rates of change can be added (BaseRates).
/// Everything here is compiled once per instruction set and chosen at run time (Kernels).
namespace leeway::nn {

/// Memory that begins at a multiple of 64 bytes. Vector code handles the elements before such a boundary apart, with
/// other roundings: only equally aligned numbers give equal bits. Everything that kernels read or write is kept so.
template <typename T>
struct AlignedAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};
  AlignedAllocator() = default;
  template <typename U>
  explicit(false) AlignedAllocator(const AlignedAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), kAlignment)); }
  void deallocate(T* memory, std::size_t) { ::operator delete(memory, kAlignment); }
  friend bool operator==(AlignedAllocator, AlignedAllocator) { return true; }
};
template <typename T>
using AlignedVector = std::vector<T, AlignedAllocator<T>>;

/// A feedforward network. Its parameters are one array: for each layer the weights (outputs x inputs, column-major),
/// then the biases.
struct NetworkShape {
  int inputs = 0, hidden_layers = 0, hidden_units = 0, outputs = 0;

  friend bool operator==(const NetworkShape&, const NetworkShape&) = default;
};

int layer_count(const NetworkShape& shape);
int layer_inputs(const NetworkShape& shape, int layer);
int layer_outputs(const NetworkShape& shape, int layer);
std::size_t parameter_count(const NetworkShape& shape);

/// Weights and biases uniform in +-1/sqrt(fan-in), as PyTorch's Linear starts.
AlignedVector<float> initial_parameters(const NetworkShape& shape, RandomStream& random);

/// What a rollout needs to know besides the parameters. SI units and radians. Arrays are owned by others.
template <typename S>
struct RolloutModel {
  NetworkShape dynamics;       ///< 3 + controls + 2 wind inputs -> 3 accelerations
  NetworkShape initial_state;  ///< -> 6 corrections of (x0, y0, psi, u, v_m, r); outputs = 0 where there is none
  int controls = 0;            ///< actuator channels
  bool wind = false;           ///< whether the apparent wind is an input
  S dt = 0;                    ///< [s]
  const S* input_mean = nullptr;
  const S* input_inverse_sd = nullptr;     ///< as many as dynamics.inputs
  const S* output_offset = nullptr;        ///< 3
  const S* output_scale = nullptr;         ///< 3
  const S* initial_state_scale = nullptr;  ///< 6
};

/// Rates of (u, v_m, r, psi) that are known beforehand and act beside the network, as means over a step: velocities
/// change by both, the heading by this alone. Nothing: nullptr, and the heading follows from r.
template <typename S>
struct BaseRates {
  const void* object = nullptr;
  /// For `n` windows from `first` on at point `step`, in nu [n][3] and psi [n]: rates [n][4] and their derivatives
  /// [n][4][4], that of rate i by state j at [j][i].
  void (*evaluate)(const void* object, int step, int first, int n, const S* nu, const S* psi, S* rates,
                   S* derivatives) = nullptr;
};

/// Windows side by side. Blocks of one point follow each other; inside a block the windows are columns.
template <typename S>
struct RolloutBatch {
  int windows = 0, points = 0;              ///< points of the longest window
  const S* nu_observed = nullptr;           ///< [points][windows][3]
  const S* weight = nullptr;                ///< [points][windows][3]: 1 / sigma^2, zero beyond a window's end
  const S* psi_initial = nullptr;           ///< [windows]
  const S* controls = nullptr;              ///< [points][windows][controls]
  const S* true_wind = nullptr;             ///< [points][windows][2], from-vector in earth axes
  const S* initial_state_inputs = nullptr;  ///< [windows][initial_state.inputs], standardized
  const S* initial_state_mask = nullptr;    ///< [windows]: 0 where the start stays as observed
  BaseRates<S> base;
  double count = 1.0;  ///< the loss is the sum over all points divided by this
};

struct AdamSettings {
  double learning_rate = 1e-4, beta1 = 0.9, beta2 = 0.999, epsilon = 1e-8;
};

/// One implementation of the hot loops. What a kernel computes for a window or a column does not depend on what stands
/// beside it; gradients are sums over a batch in an order that does not depend on the width of vectors.
template <typename S>
struct Kernels {
  std::string_view name;
  void* (*make_workspace)();
  void (*free_workspace)(void*);
  /// The weights of a network, packed for evaluation; threads may share it.
  void* (*make_network)(const NetworkShape&, const S* parameters);
  void (*free_network)(void*);
  /// Loss and its gradient by backpropagation through time. `parameters` and `gradient` hold the dynamics network,
  /// then the initial-state network.
  double (*loss_and_gradient)(void* workspace, const RolloutModel<S>&, const RolloutBatch<S>&, const S* parameters,
                              S* gradient);
  /// accelerations [n][3] of raw inputs [n][dynamics.inputs].
  void (*accelerations)(void* workspace, const RolloutModel<S>&, const void* dynamics, const S* inputs, int n,
                        S* accelerations);
  /// outputs [n][shape.outputs] of a plain network for inputs [n][shape.inputs].
  void (*forward)(void* workspace, const void* network, const S* inputs, int n, S* outputs);
  /// Adam's update number `step` (from 1) of n parameters with moments m and v.
  void (*adam)(const AdamSettings&, long step, std::size_t n, const S* gradient, S* parameters, S* m, S* v);
  /// The hidden units' function, for measuring its error.
  void (*tanh)(const S* x, std::size_t n, S* result);
  /// Nothing but multiply-adds in registers, for measuring what the processor can do; returns their number of floating
  /// point operations.
  double (*multiply_adds)(long repeats);
};

/// The kernels that this processor can run: avx512, avx2, portable; "auto" is the first of them.
std::vector<std::string> available_kernels();

/// Kernels by name, "auto" for the first. Throws UsageError for one that is unknown or that the processor lacks.
const Kernels<float>& kernels(std::string_view name = "auto");

/// Whether two kernels compute the same bits: avx2 and avx512 do, in training and prediction; portable has no fused
/// multiply-add. A name that is unknown agrees with itself alone.
bool give_same_bits(std::string_view kernel, std::string_view other);

/// The portable kernels in double precision, for checking gradients.
const Kernels<double>& kernels_double();

/// Owns a workspace.
template <typename S>
class KernelWorkspace {
 public:
  explicit KernelWorkspace(const Kernels<S>& kernels) : memory_(kernels.make_workspace(), kernels.free_workspace) {}
  void* get() const { return memory_.get(); }

 private:
  std::unique_ptr<void, void (*)(void*)> memory_;
};

/// Owns the packed weights of a network; independent of the parameters that it was made of.
template <typename S>
class PackedNetwork {
 public:
  PackedNetwork(const Kernels<S>& kernels, const NetworkShape& shape, const S* parameters)
      : memory_(kernels.make_network(shape, parameters), kernels.free_network) {}
  const void* get() const { return memory_.get(); }

 private:
  std::unique_ptr<void, void (*)(void*)> memory_;
};

}  // namespace leeway::nn
