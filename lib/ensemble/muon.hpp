#pragma once

#include <vector>

#include <Eigen/Core>

#include "nn/rollout.hpp"

namespace leeway::ensemble {

/// The matrix with the singular vectors of m and singular values near 1 (0.68 to 1.13 where those of m are at least
/// 1/100 of its Frobenius norm): five Newton-Schulz steps of the quintic a s + b s^3 + c s^5 on m divided by that norm.
/// Source: Jordan et al. (2024), "Muon: An optimizer for hidden layers in neural networks", its coefficients.
Eigen::MatrixXf orthogonalized(const Eigen::MatrixXf& m);

/// Muon: the weights between hidden layers move along their orthogonalized momentum,
///   M <- 0.95 M + G,   W <- W - rate orthogonalized(G + 0.95 M),
/// so that all directions of a layer learn at the same rate.
class Muon {
 public:
  /// Finds the hidden matrices of networks whose parameters follow each other.
  explicit Muon(const std::vector<nn::NetworkShape>& shapes);

  /// Numbers in the momentum.
  std::size_t size() const { return size_; }

  /// Moves the hidden matrices and sets their gradients to zero, so that Adam, its moments zero there, leaves them
  /// alone.
  void step(double rate, nn::AlignedVector<float>& gradient, nn::AlignedVector<float>& parameters,
            nn::AlignedVector<float>& momentum) const;

 private:
  struct Matrix {
    std::size_t begin;  ///< in the parameters
    int units;          ///< rows and columns
  };
  std::vector<Matrix> matrices_;
  std::size_t size_ = 0;
};

}  // namespace leeway::ensemble
