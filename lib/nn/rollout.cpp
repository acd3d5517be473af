#include "nn/rollout.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"

namespace leeway::nn {

// Defined by rollout_kernel.cpp, which is compiled once for each.
namespace portable {
const Kernels<float>& kernels_float();
const Kernels<double>& kernels_double();
}  // namespace portable
#ifdef LEEWAY_X86_KERNELS
namespace avx2 {
const Kernels<float>& kernels_float();
}
namespace avx512 {
const Kernels<float>& kernels_float();
}
#endif

#ifdef LEEWAY_X86_KERNELS
namespace {

bool has_avx512() {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
}

}  // namespace
#endif

int layer_count(const NetworkShape& shape) { return shape.hidden_layers + 1; }

int layer_inputs(const NetworkShape& shape, int layer) { return layer == 0 ? shape.inputs : shape.hidden_units; }

int layer_outputs(const NetworkShape& shape, int layer) {
  return layer == shape.hidden_layers ? shape.outputs : shape.hidden_units;
}

std::size_t parameter_count(const NetworkShape& shape) {
  if (shape.outputs == 0) return 0;
  std::size_t count = 0;
  for (int layer = 0; layer < layer_count(shape); ++layer)
    count += static_cast<std::size_t>(layer_outputs(shape, layer)) * (layer_inputs(shape, layer) + 1);
  return count;
}

AlignedVector<float> initial_parameters(const NetworkShape& shape, RandomStream& random) {
  AlignedVector<float> parameters;
  parameters.reserve(parameter_count(shape));
  if (shape.outputs == 0) return parameters;
  for (int layer = 0; layer < layer_count(shape); ++layer) {
    const double bound = 1.0 / std::sqrt(static_cast<double>(layer_inputs(shape, layer)));
    const int count = layer_outputs(shape, layer) * (layer_inputs(shape, layer) + 1);
    for (int i = 0; i < count; ++i) parameters.push_back(static_cast<float>(random.uniform(-bound, bound)));
  }
  return parameters;
}

std::vector<std::string> available_kernels() {
  std::vector<std::string> names;
#ifdef LEEWAY_X86_KERNELS
  if (has_avx512()) names.emplace_back("avx512");
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) names.emplace_back("avx2");
#endif
  names.emplace_back("portable");
  return names;
}

const Kernels<float>& kernels(std::string_view name) {
  const std::vector<std::string> available = available_kernels();
  if (name == "auto") name = available.front();
  if (std::find(available.begin(), available.end(), name) == available.end())
    throw UsageError(fmt::format("kernel '{}' is unknown or not available on this processor; available: {}", name,
                                 fmt::join(available, ", ")));
#ifdef LEEWAY_X86_KERNELS
  if (name == "avx512") return avx512::kernels_float();
  if (name == "avx2") return avx2::kernels_float();
#endif
  return portable::kernels_float();
}

bool give_same_bits(std::string_view kernel, std::string_view other) {
  const auto fused = [](std::string_view name) { return name == "avx2" || name == "avx512"; };
  return kernel == other || (fused(kernel) && fused(other));
}

const Kernels<double>& kernels_double() { return portable::kernels_double(); }

}  // namespace leeway::nn
