#include "gap/detect/score_test.hpp"

#include "core/linear_algebra.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
Projected project(const Evidence& evidence, const Eigen::VectorXd& theta, const ThetaPrior& prior) {
  const Eigen::Index p = theta.size(), count = evidence.b.size() - p;
  const Eigen::MatrixXd M = evidence.F.topLeftCorner(p, p) + prior.precision();
  const Eigen::MatrixXd cross = evidence.F.topRightCorner(p, count);
  Projected result;
  result.of_theta = M.llt().solve(cross);
  result.b = evidence.b.tail(count) - result.of_theta.transpose() * (evidence.b.head(p) - prior.pull(theta));
  result.F = evidence.F.bottomRightCorner(count, count) - cross.transpose() * result.of_theta;
  return result;
}

Eigen::MatrixXd root_of_scores(const Eigen::MatrixXd& F) {
  const Eigen::VectorXd size = F.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd scale = (size.array() > 0.0).select(size.cwiseInverse(), 0.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * F * scale.asDiagonal());
  return size.asDiagonal() * eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

ScoreTest score_test(const Eigen::VectorXd& b, const Eigen::MatrixXd& F) {
  ScoreTest test;
  const Eigen::Index n = b.size();
  test.beta = Eigen::VectorXd::Zero(n);
  test.inverse = Eigen::MatrixXd::Zero(n, n);
  if (!(F.diagonal().maxCoeff() > kPolicy.detect.least_information)) return test;
  const Eigen::VectorXd scale = F.diagonal()
                                    .cwiseMax(kPolicy.detect.least_relative_information * F.diagonal().maxCoeff())
                                    .cwiseSqrt()
                                    .cwiseInverse();
  const Eigen::MatrixXd correlation = scale.asDiagonal() * F * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double value = eigen.eigenvalues()[i];
    if (value < kPolicy.detect.least_eigenvalue * static_cast<double>(n)) continue;
    const Eigen::VectorXd v = scale.cwiseProduct(eigen.eigenvectors().col(i));
    test.inverse += v * v.transpose() / value;
    ++test.rank;
  }
  test.beta = test.inverse * b;
  test.statistic = b.dot(test.beta);
  return test;
}

}  // namespace leeway::gap
