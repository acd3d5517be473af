#pragma once

#include "nn/rollout.hpp"

/// What the kernels of lib/nn compute, in plain matrix products of Eigen: the reference that they are tested against.
namespace leeway::test {

/// As Kernels::loss_and_gradient.
template <typename S>
double reference_loss_and_gradient(const nn::RolloutModel<S>& model, const nn::RolloutBatch<S>& batch,
                                   const S* parameters, S* gradient);

/// As Kernels::forward, of parameters as they stand.
template <typename S>
void reference_forward(const nn::NetworkShape& shape, const S* parameters, const S* inputs, int n, S* outputs);

}  // namespace leeway::test
