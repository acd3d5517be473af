#pragma once

#include <cmath>

#include "core/linear_algebra.hpp"
#include "recording/samples.hpp"

namespace leeway::ensemble {

/// What a filter's innovations say of a base ship: -2 log likelihood is rest + x' A x - 2 b' x. x are the coefficients'
/// logarithms (or differences) theta, then the shares of their changes by which the inputs are ahead of the straight
/// line between samples.
struct Likelihood {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  double rest = 0.0;
  double here = 0.0;  ///< -2 log likelihood at x itself

  /// Of the first n of x alone, the shares integrated out.
  Likelihood without_shares(Eigen::Index n) const {
    const Eigen::Index shares = b.size() - n;
    const Eigen::LLT<Eigen::MatrixXd> open(precision_of_shares(n));
    const Eigen::MatrixXd gain = open.solve(A.bottomLeftCorner(shares, n));
    Likelihood result{A.topLeftCorner(n, n) - A.topRightCorner(n, shares) * gain,
                      b.head(n) - gain.transpose() * b.tail(shares), rest, here};
    const Eigen::MatrixXd L = open.matrixL();
    result.rest += 2.0 * (L.diagonal() * std::sqrt(kInputShareVariance)).array().log().sum() -
                   b.tail(shares).dot(open.solve(b.tail(shares)));
    return result;
  }
  /// The likeliest shares with given coefficients.
  Eigen::VectorXd shares(const Eigen::VectorXd& theta) const {
    const Eigen::Index n = theta.size(), count = b.size() - n;
    return precision_of_shares(n).llt().solve(b.tail(count) - A.bottomLeftCorner(count, n) * theta);
  }

 private:
  Eigen::MatrixXd precision_of_shares(Eigen::Index n) const {
    const Eigen::Index count = b.size() - n;
    Eigen::MatrixXd result = A.bottomRightCorner(count, count);
    result.diagonal().array() += 1.0 / kInputShareVariance;
    return result;
  }
};

}  // namespace leeway::ensemble
