#pragma once

#include <optional>

#include "ensemble/training_data.hpp"

namespace leeway::ensemble {

/// What recordings tell of how wrong a base ship is.
struct BaseSpreadEstimate {
  double spread = 1.0;                     ///< median of S
  double low = 0.0, high = 0.0;            ///< its 5 and 95 % quantiles
  Vec3<double> acceleration_noise;         ///< [m/s^2 s^0.5, ..., rad/s^2 s^0.5]: what no coefficient explains
  std::vector<CoefficientFactor> factors;  ///< the likeliest coefficients, over those of the base ship
  /// Given S: what the recordings leave open of the factors' logarithms, and of differences where the ship's file
  /// states an absolute uncertainty.
  Eigen::MatrixXd covariance;
};

/// The one scale S of all stated standard deviations of the base ship's coefficients, by marginal likelihood: a Kalman
/// filter follows (u, v_m, r) through the recordings with the base ship's equations and inputs that are linear between
/// samples (held ones would pass for wrong coefficients), observations with the config's sigma, and white noise of the
/// accelerations whose three levels are fitted along. A change of an input may come earlier or later
/// between two samples by the same share everywhere, uniform: a rudder that always moves right after a sample would
/// pass for other coefficients. The coefficients' logarithms, normal with covariance S^2 Lambda,
/// enter linearly about their likeliest values and are integrated out. ln S has the prior N(0, 1): what a file states
/// is meant, within a factor of three or so.
///   data        prepared with the base ship itself
///   recordings  those of the data
///   spread      S where it is given; else inferred
///   jobs        threads; the result does not depend on them
///   near        the base ship fitted to recordings most of which these are, to start from; nothing: from the base ship
BaseSpreadEstimate infer_base_spread(const TrainingData& data, std::vector<Trajectory> recordings,
                                     std::optional<double> spread = std::nullopt, std::size_t jobs = 1,
                                     const BaseModel* near = nullptr);

/// The base ship with the likeliest coefficients, its file stating as `coefficient_covariance` what the recordings
/// leave open of them: draws from it are draws from the posterior.
std::shared_ptr<const BaseModel> calibrated(const BaseModel& base, const BaseSpreadEstimate& by);

}  // namespace leeway::ensemble
