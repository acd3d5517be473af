#pragma once

#include "gap/filter/state_space.hpp"
#include "gap/fit/theta_prior.hpp"

namespace leeway::gap {

/// What recordings say about columns once theta, with its prior, has explained what it can of them: beta has the score
/// b and the information F, and b ~ N(0, F) where there is nothing.
struct Projected {
  Eigen::VectorXd b;
  Eigen::MatrixXd F;
  Eigen::MatrixXd of_theta;  ///< columns of theta that imitate each column, p x count
};
Projected project(const Evidence& evidence, const Eigen::VectorXd& theta, const ThetaPrior& prior);

/// A root of F, which standard normal numbers times it become such scores by. Columns are scaled to correlations first:
/// a small one would drown in the rounding of those that are a million times larger.
Eigen::MatrixXd root_of_scores(const Eigen::MatrixXd& F);

/// b' F^-1 b over the directions that the recordings determine, and their number.
struct ScoreTest {
  double statistic = 0.0;
  int rank = 0;
  Eigen::VectorXd beta;
  Eigen::MatrixXd inverse;  ///< of F in these directions
};
ScoreTest score_test(const Eigen::VectorXd& b, const Eigen::MatrixXd& F);

}  // namespace leeway::gap
