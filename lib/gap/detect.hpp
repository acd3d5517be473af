#pragma once

#include "gap/effect_library.hpp"

namespace leeway::gap {

struct DetectOptions {
  double false_alarm = 0.01;
  std::size_t jobs = 1;
  std::uint64_t seed = 1;
  std::size_t refitted = 6;  ///< effects for which the noise levels are estimated anew
};

/// What recordings say about columns once theta, with its prior, has been taken out of them: beta has the score b and
/// the information F, and b ~ N(0, F) where there is nothing.
struct Projected {
  Eigen::VectorXd b;
  Eigen::MatrixXd F;
  Eigen::MatrixXd of_theta;  ///< columns of theta that imitate each column, p x count
};
Projected project(const Evidence& evidence, const Eigen::VectorXd& theta, const Eigen::VectorXd& prior_sd);

/// b' F^-1 b over the directions that the recordings determine, and their number.
struct ScoreTest {
  double statistic = 0.0;
  int rank = 0;
  Eigen::VectorXd beta;
  Eigen::MatrixXd inverse;  ///< of F in these directions
};
ScoreTest score_test(const Eigen::VectorXd& b, const Eigen::MatrixXd& F);

/// Tests every effect of the library against the null fit. Parameters may err by twice their stated uncertainty, so
/// that a wrong coefficient is not called missing physics. For the most likely effects the model error is estimated
/// anew with the effect, the degrees of freedom of this estimate are counted (Satterthwaite 1946), and correlation left
/// between blocks widens the errors. The p-value is that of the largest of all statistics, with their correlations.
Detection detect(const Campaign& campaign, const FittedNull& fit, const EffectLibrary& library,
                 const DetectOptions& options);

/// Blocks of the recordings that are left out in turn: whole recordings, or pieces of a few.
std::vector<std::vector<std::size_t>> folds_of(const Campaign& campaign,
                                               const std::vector<std::size_t>& stretch_of_block);

/// Ljung & Box (1978), over all channels and lags up to 10; `largest` is the largest autocorrelation in absolute value.
struct Whiteness {
  double p_value = 1.0, largest = 0.0;
};
Whiteness whiteness(const FittedNull& fit);

}  // namespace leeway::gap
