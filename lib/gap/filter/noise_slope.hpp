#pragma once

#include <vector>

#include "gap/filter/state_space.hpp"

/// Derivatives of the likelihood by the levels of the noise, from one way of the filter and one back (Koopman &
/// Shephard, 1992, "Exact score for time series models in state space form", Biometrika 79, 823-826), with parameters
/// integrated out. All together they cost about as much as the filter takes for 2.5 ways; differences take two ways
/// for each level.
namespace leeway::gap {

/// What a filter knew along a stretch, kept for its way back.
struct Passage {
  std::vector<std::size_t> first_taken;  ///< of each point, in `taken`; and one past the last
  std::vector<Filter::Taken> taken;
  Eigen::VectorXd innovations;             ///< as many as taken, with variance 1
  ByRow<Eigen::Dynamic> rows;              ///< their derivatives by the columns' parameters
  std::vector<Filter::Vector> mean;        ///< after each point's measurements
  std::vector<Filter::Matrix> covariance;  ///< the same
  /// The same: derivatives by the columns' parameters of the errors that a level of the noise decays, kDecaying rows a
  /// point: w, n.
  ByRow<Eigen::Dynamic> errors;
  static constexpr int kDecaying = 5;
};

/// d ln p / d ln of the levels.
struct NoiseSlope {
  Vec3<double> sigma_w = Vec3<double>::Zero();
  double tau = 0.0;
  Vec6 measurement_sd = Vec6::Zero();
  double wind_share = 0.0, receiver_sd = 0.0, receiver_tau = 0.0;

  NoiseSlope& operator+=(const NoiseSlope& other);
};

/// Of ln of the integral of p(y | beta) N(beta; prior) over the columns' parameters, a stretch's part.
///   mean  of beta given all stretches
///   root  a root of its covariance V = root root'
NoiseSlope noise_slope(const LinearStretch& stretch, const Noise& noise, const Passage& passage,
                       const Eigen::VectorXd& mean, const Eigen::MatrixXd& root);

}  // namespace leeway::gap
