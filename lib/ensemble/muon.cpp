#include "ensemble/muon.hpp"

namespace leeway::ensemble {
namespace {

constexpr float kMomentum = 0.95F;

}  // namespace

Eigen::MatrixXf orthogonalized(const Eigen::MatrixXf& m) {
  constexpr float a = 3.4445F, b = -4.7750F, c = 2.0315F;
  constexpr int kSteps = 5;
  // The smaller of the two products of m with itself.
  if (m.rows() > m.cols()) return orthogonalized(m.transpose()).transpose();
  const float norm = m.norm();
  if (!(norm > 0.0F)) return m;
  Eigen::MatrixXf x = m / norm;
  for (int i = 0; i < kSteps; ++i) {
    const Eigen::MatrixXf square = x * x.transpose();
    const Eigen::MatrixXf factor = b * square + c * square * square;
    x = a * x + factor * x;
  }
  return x;
}

Muon::Muon(const std::vector<nn::NetworkShape>& shapes) {
  std::size_t layer = 0;  // where its parameters begin
  for (const nn::NetworkShape& shape : shapes) {
    if (shape.outputs == 0) continue;
    for (int l = 0; l < nn::layer_count(shape); ++l) {
      if (l > 0 && l < shape.hidden_layers) {
        matrices_.push_back({layer, shape.hidden_units});
        size_ += static_cast<std::size_t>(shape.hidden_units) * shape.hidden_units;
      }
      layer += static_cast<std::size_t>(nn::layer_outputs(shape, l)) * (nn::layer_inputs(shape, l) + 1);
    }
  }
}

void Muon::step(double rate, nn::AlignedVector<float>& gradient, nn::AlignedVector<float>& parameters,
                nn::AlignedVector<float>& momentum) const {
  std::size_t next = 0;
  for (const auto& [begin, n] : matrices_) {
    Eigen::Map<Eigen::MatrixXf> G(gradient.data() + begin, n, n), W(parameters.data() + begin, n, n);
    Eigen::Map<Eigen::MatrixXf> M(momentum.data() + next, n, n);
    M = kMomentum * M + G;
    W -= static_cast<float>(rate) * orthogonalized(G + kMomentum * M);
    G.setZero();
    next += static_cast<std::size_t>(n) * n;
  }
}

}  // namespace leeway::ensemble
