// The hot loops, compiled once per instruction set with LEEWAY_KERNEL naming the namespace (lib/CMakeLists.txt).
// Everything but the table at the end has internal linkage, and nothing from elsewhere may be instantiated here: the
// linker cannot mix instruction sets then (tests/nn/kernel_symbols.cmake).
#include "nn/block_rollout.hpp"
#include "nn/evaluation.hpp"

#define LEEWAY_TEXT(a) #a
#define LEEWAY_TEXT_EXPANDED(a) LEEWAY_TEXT(a)

namespace leeway::nn::LEEWAY_KERNEL {
namespace {

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
