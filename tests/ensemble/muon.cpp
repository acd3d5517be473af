#include "ensemble/muon.hpp"

#include <Eigen/SVD>
#include <catch2/catch.hpp>

#include "core/random.hpp"

using namespace leeway;
using namespace leeway::ensemble;
using Catch::Matchers::WithinAbs;

namespace {

Eigen::MatrixXf random_matrix(std::uint64_t seed, int rows, int columns) {
  RandomStream random(seed, "matrix");
  Eigen::MatrixXf m(rows, columns);
  for (float& x : m.reshaped()) x = static_cast<float>(random.normal());
  return m;
}

// What five Newton-Schulz steps make of a singular value.
double iterated(double s) {
  for (int i = 0; i < 5; ++i) s = 3.4445 * s - 4.7750 * s * s * s + 2.0315 * s * s * s * s * s;
  return s;
}

}  // namespace

TEST_CASE("muon: orthogonalization keeps singular vectors and brings singular values near 1", "[ensemble][muon]") {
  for (const auto& [rows, columns] : {std::pair{48, 48}, std::pair{20, 50}, std::pair{50, 20}}) {
    CAPTURE(rows, columns);
    const Eigen::MatrixXf m = random_matrix(3, rows, columns);
    const Eigen::MatrixXd O = orthogonalized(m).cast<double>();
    const Eigen::MatrixXd normalized = m.cast<double>() / m.cast<double>().norm();
    const Eigen::BDCSVD<Eigen::MatrixXd> svd(normalized, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const Eigen::VectorXd values = svd.singularValues();
    const Eigen::MatrixXd expected =
        svd.matrixU() * values.unaryExpr([](double s) { return iterated(s); }).asDiagonal() * svd.matrixV().transpose();
    // Rounding of single precision, through five steps that stretch by up to 3.4 each.
    CHECK((O - expected).cwiseAbs().maxCoeff() < 2e-4);
    CHECK((O - svd.matrixU() * svd.matrixV().transpose()).norm() < 0.35 * std::sqrt(values.size()));
    if (values.minCoeff() < 0.01) continue;
    for (const double s : Eigen::VectorXd(Eigen::BDCSVD<Eigen::MatrixXd>(O).singularValues())) {
      CHECK(s > 0.67);
      CHECK(s < 1.14);
    }
  }
}

TEST_CASE("muon: singular values above 1/100 of the norm end between 0.68 and 1.13", "[ensemble][muon]") {
  for (double s = 0.01; s <= 1.0; s += 0.0005) {
    CAPTURE(s);
    CHECK(iterated(s) > 0.67);
    CHECK(iterated(s) < 1.14);
  }
}

TEST_CASE("muon: the scale of the gradient does not matter, and none moves nothing", "[ensemble][muon]") {
  const Eigen::MatrixXf m = random_matrix(5, 16, 16);
  CHECK((orthogonalized(m) - orthogonalized(1e-6F * m)).cwiseAbs().maxCoeff() < 1e-4F);
  CHECK(orthogonalized(Eigen::MatrixXf::Zero(4, 4)).norm() == 0.0F);
}

TEST_CASE("muon: hidden matrices move along their orthogonalized momentum, all else stays", "[ensemble][muon]") {
  // Layers of 3 -> 4 -> 4 -> 4 -> 2: two hidden matrices, at 16 and 36; then one of 2 -> 4 -> 4 -> 1, at 56 + 10 + 12.
  const std::vector<nn::NetworkShape> shapes{{3, 3, 4, 2}, {2, 2, 4, 1}};
  const Muon muon(shapes);
  REQUIRE(muon.size() == 3 * 16);
  const std::size_t begins[] = {16, 36, 66 + 12};
  nn::AlignedVector<float> parameters, gradient;
  RandomStream random(1, "parameters");
  for (std::size_t i = 0; i < nn::parameter_count(shapes[0]) + nn::parameter_count(shapes[1]); ++i) {
    parameters.push_back(static_cast<float>(random.normal()));
    gradient.push_back(static_cast<float>(random.normal()));
  }
  nn::AlignedVector<float> moved = parameters, momentum(muon.size(), 0.5F), g = gradient;
  muon.step(0.1, g, moved, momentum);
  std::vector<bool> hidden(parameters.size(), false);
  for (std::size_t k = 0; k < 3; ++k) {
    CAPTURE(k);
    const Eigen::Map<const Eigen::Matrix4f> G(gradient.data() + begins[k]), before(parameters.data() + begins[k]),
        after(moved.data() + begins[k]), M(momentum.data() + 16 * k);
    CHECK((M - (Eigen::Matrix4f::Constant(0.95F * 0.5F) + G)).norm() < 1e-6F);
    const Eigen::Matrix4f expected = before - 0.1F * orthogonalized(G + 0.95F * M);
    CHECK((after - expected).norm() < 1e-6F);
    std::fill_n(hidden.begin() + static_cast<std::ptrdiff_t>(begins[k]), 16, true);
  }
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    CAPTURE(i);
    CHECK(g[i] == (hidden[i] ? 0.0F : gradient[i]));
    if (!hidden[i]) CHECK(moved[i] == parameters[i]);
  }
}

TEST_CASE("muon: products are cut into the same blocks on every processor", "[ensemble][muon]") {
  CHECK(Eigen::l1CacheSize() == 32 * 1024);
  CHECK(Eigen::l2CacheSize() == 256 * 1024);
  CHECK(Eigen::l3CacheSize() == 2 * 1024 * 1024);
}
