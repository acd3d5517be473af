#pragma once

#include "gap/findings.hpp"
#include "gap/state_space.hpp"

namespace leeway::gap {

/// The simulator fitted within its stated uncertainty: parameters, noise levels, and the model along the smoothed path.
struct FittedNull {
  std::vector<UncertainParameter> parameters;
  Eigen::VectorXd theta;  ///< ln of the factors
  Noise noise;
  std::vector<LinearStretch> stretches;  ///< linearized at theta along the smoothed paths
  std::vector<Smoothed> smoothed;
  Evidence total;  ///< about theta, at the end
  NullFit report;
};

struct FitOptions {
  std::size_t jobs = 1;
  int most_iterations = 30;
  std::function<void(double done, const std::string& note)> progress;  ///< done in 0..1
};

/// Maximizes the marginal likelihood: the paths are integrated out by the filter, the parameters theta ~ N(0, log_sd^2)
/// by Laplace's method, around paths and parameters that are renewed until they rest; noise levels by BFGS (Ceres).
/// Measurements farther than 6 sd from their prediction are left out and counted.
FittedNull fit_null(Campaign& campaign, const FitOptions& options);

/// ln of the integral of exp(log_likelihood + b'd - d'Fd/2) N(theta + d; 0, sd^2) over d.
double marginal(const Evidence& evidence, const Eigen::VectorXd& theta, const Eigen::VectorXd& prior_sd);

/// Sum of evidence() over the stretches, on several threads.
Evidence total_evidence(const std::vector<LinearStretch>& stretches, const Noise& noise, std::size_t jobs);

}  // namespace leeway::gap
