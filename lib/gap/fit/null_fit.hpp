#pragma once

#include "gap/fit/hypothesis.hpp"
#include "gap/fit/levels.hpp"
#include "gap/policy/policy.hpp"
#include "gap/result/findings.hpp"

namespace leeway::gap {

/// The simulator fitted within its stated uncertainty: parameters, noise levels, and the model along the smoothed path.
struct FittedNull {
  std::vector<UncertainParameter> parameters;
  /// ln of the factors, numbers of sensors' faults that are free, coordinates of effects that are fitted, the timing.
  Eigen::VectorXd theta;
  Eigen::Index faults = 0, effects = 0;  ///< how many of the second and third
  Noise noise;
  std::vector<LinearStretch> stretches;  ///< linearized at theta along the filtered paths
  std::vector<Smoothed> smoothed;
  std::vector<std::vector<Vec3<double>>> event_scale;  ///< of each stretch, as LinearStretch has it
  double log_prior_of_events = 0.0;                    ///< each block and axis as likely as one event in all is
  Evidence total;                                      ///< about theta, at the end
  ThetaPrior stated;                                   ///< of theta, as the ship's file has it
  ThetaPrior prior;                                    ///< the same at the likeliest common scale of the coefficients
  double scale = 1.0;  ///< that one: by which the coefficients are more uncertain than stated
  Levels level_prior_mean, level_prior_sd;
  LevelCurvature level_curvature = LevelCurvature::Identity();
  NullFit report;

  Eigen::Index coefficients() const { return theta.size() - 1 - effects - faults; }
};

struct FitOptions {
  std::size_t jobs = 1;
  int most_iterations = static_cast<int>(kPolicy.fit.most_iterations);
  std::function<void(double done, const std::string& note)> progress = {};  ///< done in 0..1
};

/// Maximizes the marginal likelihood: the paths are integrated out by the filter, the parameters theta ~ N(0, (c
/// sd)^2) by Laplace's method, around paths and parameters that are renewed until they converge; noise levels
/// by BFGS (Ceres). Measurements farther than 6 sd from what all others predict are left out and counted. Where the
/// model error of a block of 10 s (at 3 m) has more than 16 times its mean square, something acts that comes and goes:
/// there it may be as large as it is, so that a tug or a mooring line does not count as the simulator's everyday error.
///   near_by  where to begin: parameters and noise levels of nearly the same recordings
FittedNull fit_null(const Campaign& campaign, const FitOptions& options, const FittedNull* near_by = nullptr);

/// The campaign without the measurements that a fit left out, for the stages that follow.
Campaign without_outliers(Campaign campaign, const FittedNull& fit);

/// The same with effects whose coordinates are fitted beside the coefficients, from another fit on: its data, paths,
/// noise levels and events are where it begins, and its prior widths hold; the noise of the measurements is known then.
/// What an effect explains is no event any more.
/// theta is then (coefficients, z, timing). The campaign stays as it is, also where the fit throws: what a fit changes
/// (inputs as rudders follow them late, outliers) it owns.
///   theta0  to start from
FittedNull fit_with(const Campaign& campaign, const FittedNull& from, const Hypothesis& hypothesis,
                    const Eigen::VectorXd& theta0, const FitOptions& options);

/// Other recordings with the parameters and noise levels of a fit: nothing is fitted but their paths.
FittedNull follow(const Campaign& campaign, const FittedNull& fit, const Hypothesis& hypothesis, std::size_t jobs);

/// ln p(recordings | hypothesis), by Laplace's method at the best coefficients, effects and noise levels, averaged over
/// how wrong the ship's file is.
double log_evidence(const FittedNull& fit);

/// Covariance of theta, given the recordings.
Eigen::MatrixXd posterior_covariance(const FittedNull& fit);

/// Coordinates of the effects, and their covariance.
struct Coordinates {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};
Coordinates coordinates_of(const FittedNull& fit);
/// The same as the recordings alone say, whatever was believed before: an interval has to hold the true strength
/// however strong it is, not in the mean over those that were expected. What was not measured goes no farther than fits
/// do.
Coordinates without_prior(const Coordinates& z);

}  // namespace leeway::gap
