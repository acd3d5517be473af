#pragma once

#include "gap/fit/minimizer.hpp"

namespace leeway::gap {

// What minimizer.cpp and the module agree on.
using MinimizeFunction = void (*)(const Objective&, std::vector<double>&, const MinimizerLimits&);
inline constexpr const char* kMinimizerModule = "lib/leeway/minimizer.so";
inline constexpr const char* kMinimizeSymbol = "leeway_minimize";

}  // namespace leeway::gap
