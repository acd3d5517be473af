#include "gap/fit/minimizer.hpp"

#include <cstdlib>
#include <dlfcn.h>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "gap/fit/minimizer_module.hpp"
#include "io/files.hpp"

namespace leeway::gap {
namespace {

MinimizeFunction load_module() {
  // None of these libraries has work for threads here.
  for (const char* pool : {"OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"}) ::setenv(pool, "1", 0);
  const std::string path = io::installed_file(kMinimizerModule);
  void* const module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) throw IoError(path, fmt::format("cannot be loaded: {}", ::dlerror()));
  return reinterpret_cast<MinimizeFunction>(::dlsym(module, kMinimizeSymbol));
}

}  // namespace

void minimize(const Objective& objective, std::vector<double>& parameters, const MinimizerLimits& limits) {
  static const MinimizeFunction run = load_module();
  run(objective, parameters, limits);
}

}  // namespace leeway::gap
