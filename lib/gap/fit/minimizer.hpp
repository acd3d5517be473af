#pragma once

#include <functional>
#include <vector>

namespace leeway::gap {

/// Value and gradient at the parameters; `gradient` is null where nobody asks for it. False where there is no value.
using Objective = std::function<bool(const double* parameters, double* value, double* gradient)>;

struct MinimizerLimits {
  int most_iterations;
  double gradient_tolerance, function_tolerance;
};

/// Moves the parameters to a minimum, by BFGS with a line search. Ceres does it, from a module beside the tools that is
/// loaded by the first call: libraries of linear algebra come with it, of which OpenBLAS starts a pool of threads as
/// soon as it is loaded, and where threads are refused a tool that ends would wait for them forever. Throws IoError
/// where the module is missing.
void minimize(const Objective& objective, std::vector<double>& parameters, const MinimizerLimits& limits);

}  // namespace leeway::gap
