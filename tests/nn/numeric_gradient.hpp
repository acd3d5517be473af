#pragma once

#include <algorithm>
#include <cmath>

#include "nn/rollout.hpp"

namespace leeway::test {

inline double largest_component(const nn::AlignedVector<double>& gradient) {
  double largest = 0.0;
  for (const double g : gradient) largest = std::max(largest, std::abs(g));
  return largest;
}

/// Largest error of a gradient against central differences of the loss, by the gradient's largest component.
///   loss(out)  of `parameters` as they stand; writes the gradient
template <typename Loss>
double gradient_error(const Loss& loss, nn::AlignedVector<double>& parameters,
                      const nn::AlignedVector<double>& gradient, double h) {
  nn::AlignedVector<double> unused(parameters.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const double saved = parameters[i];
    parameters[i] = saved + h;
    const double above = loss(unused);
    parameters[i] = saved - h;
    const double below = loss(unused);
    parameters[i] = saved;
    worst = std::max(worst, std::abs((above - below) / (2.0 * h) - gradient[i]));
  }
  return worst / largest_component(gradient);
}

}  // namespace leeway::test
