#pragma once

#include <functional>
#include <vector>

#include "gap/filter/state_space.hpp"
#include "gap/fit/theta_prior.hpp"
#include "gap/policy/policy.hpp"

/// Levels of the noise, and how well they explain the recordings.
namespace leeway::gap {

/// The noise levels as one vector of logarithms: sigma_w (3), tau, position, heading, u, v_m, r, share of the wind, sd
/// and tau of a receiver's error.
inline constexpr int kLevels = 12, kTauLevel = 3, kWindLevel = 9, kReceiverLevel = 10;
using Levels = Eigen::Matrix<double, kLevels, 1>;
using LevelCurvature = Eigen::Matrix<double, kLevels, kLevels>;
Levels levels_of(const Noise& noise);
Noise noise_of(const Levels& levels, const Noise& like);
/// Those that may move: of the model error; of the sensors, a receiver's error among them; of the wind.
std::vector<int> free_levels(bool of_sensors, bool of_wind, bool one_receiver);

/// ln of the integral of exp(log_likelihood + b'd - d'Fd/2) prior(theta + d) over d.
double marginal(const Evidence& evidence, const Eigen::VectorXd& theta, const ThetaPrior& prior);

/// Columns beside theta for each stretch: columns_of(stretch).
struct ExtraColumns {
  Eigen::Index count = 0;
  std::function<MoreColumns(std::size_t stretch)> of;
};

/// How well noise levels explain the recordings: parameters (theta and those of the extra columns) are integrated out.
struct LevelProblem {
  const std::vector<LinearStretch>& stretches;
  Eigen::VectorXd theta;  ///< with those of the extra columns, which start at zero
  ThetaPrior prior;
  ExtraColumns extra;
  Noise like;  ///< for what is not among the levels
  Levels prior_mean, prior_sd_of_levels;
  std::vector<int> free;  ///< the levels that may move
  std::size_t jobs = 1;
  std::size_t most_points =
      kPolicy.fit.points_for_levels;  ///< costs and their derivatives come from stretches with about this many points

  /// -ln posterior, and its slope by the free levels (zero by others).
  double cost(const Levels& at, Levels& slope) const;
  /// The same at each point, without slopes.
  std::vector<double> costs(const std::vector<Levels>& points) const;
  /// Sum of evidence() over the stretches, on several threads.
  Evidence total(const Noise& noise) const;
  /// The best levels near `start`, by BFGS.
  ///   curvature  of the cost, as known so far; renewed for the next time
  Levels minimize(const Levels& start, int most_iterations, LevelCurvature& curvature) const;
  /// Largest derivative of the cost by a free level that is not held by a bound.
  double gradient(const Levels& at) const;
};

}  // namespace leeway::gap
