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

/// Evidence by blocks of 60 s at 3 m.
struct Blocks {
  std::size_t points = 0;  ///< of one block; the last of a stretch may have fewer
  std::vector<Evidence> evidence;
  std::vector<std::size_t> stretch;  ///< of each
  std::vector<std::size_t> begin;    ///< first point of each in its stretch

  Evidence total() const;
};
Blocks blocks_of(const Campaign& campaign, const FittedNull& fit, const Noise& noise, const ExtraColumns& extra,
                 std::size_t jobs);

/// Blocks that are left out in turn: whole recordings, or pieces of a few.
std::vector<std::vector<std::size_t>> folds_of(const Campaign& campaign, const Blocks& blocks);

/// How much wider than the model says scores along a direction of (theta, columns) scatter between blocks, at least 1:
/// what correlation between them that the noise model does not know does to errors.
double overdispersion(const Blocks& blocks, const Eigen::VectorXd& direction, const Eigen::VectorXd& fitted);

/// Ljung & Box (1978), over all channels and lags up to 10; `largest` is the largest autocorrelation in absolute value.
struct Whiteness {
  double p_value = 1.0, largest = 0.0;
};
Whiteness whiteness(const FittedNull& fit);

}  // namespace leeway::gap
