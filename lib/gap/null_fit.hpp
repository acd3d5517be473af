#pragma once

#include "gap/findings.hpp"
#include "gap/hypothesis.hpp"
#include "gap/state_space.hpp"

namespace leeway::gap {

/// The noise levels as one vector of logarithms: sigma_w (3), tau, position, heading, u, v_m, r, share of the wind.
inline constexpr int kLevels = 10, kTauLevel = 3, kWindLevel = 9;
using Levels = Eigen::Matrix<double, kLevels, 1>;
Levels levels_of(const Noise& noise);
Noise noise_of(const Levels& levels, const Noise& like);

/// The simulator fitted within its stated uncertainty: parameters, noise levels, and the model along the smoothed path.
struct FittedNull {
  std::vector<UncertainParameter> parameters;
  Eigen::VectorXd theta;     ///< ln of the factors, then coordinates of effects that are fitted, then the timing
  Eigen::Index effects = 0;  ///< number of the coordinates
  Noise noise;
  std::vector<LinearStretch> stretches;  ///< linearized at theta along the filtered paths
  std::vector<Smoothed> smoothed;
  std::vector<std::vector<Vec3<double>>> event_scale;  ///< of each stretch, as LinearStretch has it
  double log_prior_of_events = 0.0;                    ///< each block and axis as likely as one event in all is
  Evidence total;                                      ///< about theta, at the end
  Eigen::VectorXd prior_sd;                            ///< of theta: UncertainParameter::tolerated_sd
  Levels level_prior_mean, level_prior_sd, level_unit = Levels::Ones();
  NullFit report;
};

inline constexpr double kErrorOfInputs = 0.05;  ///< by typical acceleration: what inputs between samples can make

struct FitOptions {
  std::size_t jobs = 1;
  int most_iterations = 30;
  std::function<void(double done, const std::string& note)> progress = {};  ///< done in 0..1
};

/// Maximizes the marginal likelihood: the paths are integrated out by the filter, the parameters theta ~ N(0,
/// tolerated_sd^2) by Laplace's method, around paths and parameters that are renewed until they rest; noise levels by
/// BFGS (Ceres). Measurements farther than 6 sd from what all others predict are left out and counted. Where the model
/// error of a block of 10 s (at 3 m) has more than 16 times its mean square, something acts that comes and goes: there
/// it may be as large as it is, so that a tug or a mooring line does not count as the simulator's everyday error.
///   near_by  where to begin: parameters and noise levels of nearly the same recordings
FittedNull fit_null(Campaign& campaign, const FitOptions& options, const FittedNull* near_by = nullptr);

/// The same with effects whose coordinates are fitted beside the coefficients, from another fit on: its data, paths,
/// noise levels and events are where it begins, and its prior widths hold; the noise of the measurements is known then.
/// What an effect explains is no event any more.
/// theta is then (coefficients, z, timing).
///   theta0  to start from
FittedNull fit_with(Campaign& campaign, const FittedNull& from, const Hypothesis& hypothesis,
                    const Eigen::VectorXd& theta0, const FitOptions& options);

/// Other recordings with the parameters and noise levels of a fit: nothing is fitted but their paths.
FittedNull follow(Campaign& campaign, const FittedNull& fit, const Hypothesis& hypothesis, std::size_t jobs);

/// ln p(recordings | hypothesis), by Laplace's method at the best coefficients, effects and noise levels.
double log_evidence(const FittedNull& fit);

/// Coordinates of the effects, and their covariance.
struct Coordinates {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};
Coordinates coordinates_of(const FittedNull& fit);

/// ln of the integral of exp(log_likelihood + b'd - d'Fd/2) N(theta + d; 0, sd^2) over d.
double marginal(const Evidence& evidence, const Eigen::VectorXd& theta, const Eigen::VectorXd& prior_sd);

/// Columns beside theta for each stretch: columns_of(stretch).
struct ExtraColumns {
  Eigen::Index count = 0;
  std::function<MoreColumns(std::size_t stretch)> of;
};

/// How well noise levels explain the recordings: parameters (theta and those of the extra columns) are integrated out.
struct LevelProblem {
  const std::vector<LinearStretch>& stretches;
  Eigen::VectorXd theta, prior_sd;  ///< of theta and the extra columns; the latter start at zero
  ExtraColumns extra;
  Noise like;  ///< for what is not among the levels
  Levels prior_mean, prior_sd_of_levels;
  std::vector<int> free;  ///< the levels that may move
  std::size_t jobs = 1;
  std::size_t most_points = 4000;  ///< costs and their derivatives come from stretches with about this many points

  /// -ln posterior at each point.
  std::vector<double> costs(const std::vector<Levels>& points) const;
  /// Sum of evidence() over the stretches, on several threads.
  Evidence total(const Noise& noise) const;
  /// The best levels near `start`, by BFGS with central differences.
  ///   unit  by level: a step after which the cost bends; renewed for the next time
  Levels minimize(const Levels& start, int most_iterations, Levels& unit) const;
  /// Largest derivative of the cost by a free level that is not at a bound.
  double gradient(const Levels& at) const;
};

/// Places of stretches with about `most_points` points that stand for all; of all where they have fewer.
std::vector<std::size_t> sample_of(const std::vector<LinearStretch>& stretches, std::size_t most_points);

}  // namespace leeway::gap
