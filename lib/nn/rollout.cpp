#include "nn/rollout.hpp"

#include <algorithm>
#include <cmath>
#ifdef LEEWAY_X86_KERNELS
#include <cpuid.h>
#endif
#ifdef __linux__
#include <sys/syscall.h>
#include <unistd.h>
#endif

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
namespace amx {
const Kernels<float>& kernels_float();
}
#endif

#ifdef LEEWAY_X86_KERNELS
namespace {

bool has_avx512() {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
}

// Leaf 7 of the processor's description; not every compiler knows the names of these features.
bool has_tiles_for_bf16() {
  constexpr unsigned kBf16 = 1u << 22, kTiles = 1u << 24;
  unsigned a = 0, b = 0, c = 0, d = 0;
  return __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && (d & kBf16) != 0 && (d & kTiles) != 0;
}

// Linux gives the tiles to a process that asks for them, and to the threads that it starts afterwards.
bool has_amx() {
#ifdef __linux__
  constexpr long kRequestPermission = 0x1023, kTileData = 18;  // ARCH_REQ_XCOMP_PERM, XFEATURE_XTILEDATA
  static const bool has =
      has_avx512() && has_tiles_for_bf16() && syscall(SYS_arch_prctl, kRequestPermission, kTileData) == 0;
  return has;
#else
  return false;
#endif
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
  if (has_amx()) names.emplace_back("amx");
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
  if (name == "amx") return amx::kernels_float();
  if (name == "avx512") return avx512::kernels_float();
  if (name == "avx2") return avx2::kernels_float();
#endif
  return portable::kernels_float();
}

const Kernels<double>& kernels_double() { return portable::kernels_double(); }

}  // namespace leeway::nn
