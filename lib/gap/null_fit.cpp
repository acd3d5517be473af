#include "gap/null_fit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>
#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"

namespace leeway::gap {
namespace {

constexpr double kOutlier = 6.0;       // sd of the innovation
constexpr double kThetaAtRest = 0.02;  // of a prior sd
constexpr double kNoiseAtRest = 0.03;  // of ln level
constexpr double kLargestStep = 0.7;   // of theta in one iteration
constexpr double kDifference = 0.02;   // for derivatives by ln level

// The noise levels as one vector of logarithms: sigma_w (3), tau, position, heading, u, v, r.
constexpr int kLevels = 9;
using Levels = Eigen::Matrix<double, kLevels, 1>;

Levels levels_of(const Noise& noise) {
  Levels h;
  h << noise.sigma_w, noise.tau_s, noise.measurement_sd[0], noise.measurement_sd.tail<4>();
  return h.array().log();
}

Noise noise_of(const Levels& h, const Noise& like) {
  const Levels x = h.array().exp();
  Noise noise = like;
  noise.sigma_w = x.head<3>();
  noise.tau_s = x[3];
  noise.measurement_sd << x[4], x[4], x.tail<4>();
  return noise;
}

// Weak knowledge that keeps levels finite where the recordings say nothing.
struct LevelPrior {
  Levels mean, sd;
  double cost(const Levels& h) const { return 0.5 * ((h - mean).array() / sd.array()).square().sum(); }
};

LevelPrior level_prior(const Ship& ship, double time_scale, const Noise& start) {
  LevelPrior prior;
  const double L = ship.particulars.L_pp;
  prior.mean = levels_of(start);
  // Model errors seen on model ships, the same acceleration at any scale; within a factor of 20.
  prior.mean.head<3>() << std::log(5e-4), std::log(5e-4), std::log(5e-4 / (0.25 * L));
  prior.mean[3] = std::log(12.0 * time_scale);
  prior.sd << 3.0, 3.0, 3.0, 0.5, 3.0, 3.0, 3.0, 3.0, 3.0;
  return prior;
}

double robust_sd(std::vector<double> x) {
  if (x.empty()) return 0.0;
  for (double& v : x) v = std::abs(v);
  std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
  return 1.4826 * x[x.size() / 2];
}

// From second differences, which leave little of the ship's motion.
Noise first_noise(const Campaign& campaign) {
  Noise noise;
  const double L = campaign.ship.particulars.L_pp, scale = campaign.time_scale();
  noise.sigma_w << 1e-3, 1e-3, 1e-3 / (0.25 * L);
  noise.tau_s = 12.0 * scale;
  noise.wind_tau_s = 15.0 * scale;
  const Vec6 least = (Vec6() << 1e-3, 1e-3, 1e-4, 1e-4, 1e-4, 1e-5).finished();
  for (int i = 0; i < kShipStates; ++i) {
    std::vector<double> differences;
    for (const Stretch& stretch : campaign.stretches)
      for (std::size_t k = 2; k < stretch.size(); ++k) {
        const double d = stretch.measured[k][i] - 2.0 * stretch.measured[k - 1][i] + stretch.measured[k - 2][i];
        if (std::isfinite(d)) differences.push_back(d);
      }
    noise.measurement_sd[i] = std::max(robust_sd(differences) / std::sqrt(6.0), least[i]);
  }
  noise.measurement_sd.head<2>().setConstant(noise.measurement_sd.head<2>().maxCoeff());
  return noise;
}

// -ln posterior of the noise levels, and its gradient by central differences.
class LevelCost final : public ceres::FirstOrderFunction {
 public:
  LevelCost(const FittedNull& fit, const Eigen::VectorXd& prior_sd, const LevelPrior& prior, std::size_t jobs)
      : fit_(fit), prior_sd_(prior_sd), prior_(prior), jobs_(jobs) {}

  int NumParameters() const override { return kLevels; }

  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    const Levels h = Eigen::Map<const Levels>(parameters);
    if (!h.allFinite() || h.cwiseAbs().maxCoeff() > 40.0) return false;
    std::vector<Levels> points{h};
    if (gradient != nullptr)
      for (int i = 0; i < kLevels; ++i)
        for (const double sign : {1.0, -1.0}) points.push_back(h + sign * kDifference * Levels::Unit(i));
    const std::vector<double> costs = costs_at(points);
    *cost = costs[0];
    if (gradient != nullptr)
      for (int i = 0; i < kLevels; ++i) gradient[i] = (costs[1 + 2 * i] - costs[2 + 2 * i]) / (2.0 * kDifference);
    return std::isfinite(*cost);
  }

  std::vector<double> costs_at(const std::vector<Levels>& points) const {
    const std::size_t stretches = fit_.stretches.size();
    std::vector<Evidence> parts(points.size() * stretches);
    parallel_for(parts.size(), jobs_, [&](std::size_t i) {
      parts[i] = evidence(fit_.stretches[i % stretches], noise_of(points[i / stretches], fit_.noise));
    });
    std::vector<double> costs;
    for (std::size_t i = 0; i < points.size(); ++i) {
      Evidence total(fit_.theta.size());
      for (std::size_t s = 0; s < stretches; ++s) total += parts[i * stretches + s];
      costs.push_back(-marginal(total, fit_.theta, prior_sd_) + prior_.cost(points[i]));
    }
    return costs;
  }

 private:
  const FittedNull& fit_;
  const Eigen::VectorXd& prior_sd_;
  const LevelPrior& prior_;
  std::size_t jobs_;
};

Vec3<double> typical_acceleration(const std::vector<LinearStretch>& stretches) {
  Vec3<double> sum = Vec3<double>::Zero();
  double n = 0.0;
  for (const LinearStretch& stretch : stretches)
    for (std::size_t k = 0; k + 1 < stretch.path.size(); ++k) {
      const Vec3<double> rate = (stretch.path[k + 1] - stretch.path[k]).segment<3>(3) / stretch.data->dt_s(k);
      sum += rate.cwiseAbs2();
      n += 1.0;
    }
  return (sum / n).cwiseSqrt();
}

}  // namespace

double marginal(const Evidence& evidence, const Eigen::VectorXd& theta, const Eigen::VectorXd& prior_sd) {
  const Eigen::VectorXd precision = prior_sd.array().square().inverse();
  const Eigen::VectorXd g = evidence.b - precision.cwiseProduct(theta);
  Eigen::MatrixXd M = evidence.F;
  M.diagonal() += precision;
  const Eigen::LLT<Eigen::MatrixXd> factor(M);
  const double log_det = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  return evidence.log_likelihood - 0.5 * theta.dot(precision.cwiseProduct(theta)) + 0.5 * g.dot(factor.solve(g)) -
         0.5 * log_det - prior_sd.array().log().sum();
}

Evidence total_evidence(const std::vector<LinearStretch>& stretches, const Noise& noise, std::size_t jobs) {
  std::vector<Evidence> parts(stretches.size());
  parallel_for(parts.size(), jobs, [&](std::size_t i) { parts[i] = evidence(stretches[i], noise); });
  Evidence total(stretches.front().steps.front().G.cols());
  for (const Evidence& part : parts) total += part;
  return total;
}

FittedNull fit_null(Campaign& campaign, const FitOptions& options) {
  FittedNull fit;
  fit.parameters = uncertain_parameters(campaign.ship);
  const auto p = static_cast<Eigen::Index>(fit.parameters.size());
  Eigen::VectorXd prior_sd(p);
  for (Eigen::Index i = 0; i < p; ++i) prior_sd[i] = fit.parameters[static_cast<std::size_t>(i)].log_sd;
  fit.theta = Eigen::VectorXd::Zero(p);
  fit.noise = first_noise(campaign);
  const LevelPrior prior = level_prior(campaign.ship, campaign.time_scale(), fit.noise);

  const std::size_t n = campaign.stretches.size();
  std::vector<std::vector<StateVector>> paths(n);
  for (std::size_t s = 0; s < n; ++s) paths[s] = measured_path(campaign.stretches[s]);
  fit.stretches.resize(n);
  fit.smoothed.resize(n);

  double moved = 1.0, noise_moved = 1.0;
  for (int iteration = 0;; ++iteration) {
    parallel_for(n, options.jobs, [&](std::size_t s) {
      fit.stretches[s] = linearize(campaign.ship, campaign.stretches[s], paths[s], fit.theta);
    });
    fit.total = total_evidence(fit.stretches, fit.noise, options.jobs);
    const Eigen::VectorXd precision = prior_sd.array().square().inverse();
    const Eigen::VectorXd slope = fit.total.b - precision.cwiseProduct(fit.theta);
    fit.report.iterations = iteration;
    fit.report.gradient = slope.cwiseProduct(prior_sd).cwiseAbs().maxCoeff();
    if (!std::isfinite(fit.total.log_likelihood)) throw NumericalError("the filter diverged along the recordings");
    fit.report.converged = iteration > 2 && moved < kThetaAtRest && noise_moved < kNoiseAtRest;
    if (fit.report.converged || iteration == options.most_iterations) break;

    // Noise levels, once the path has been smoothed for the first time.
    if (iteration > 0 && (noise_moved > kNoiseAtRest || moved > kThetaAtRest)) {
      Levels h = levels_of(fit.noise);
      const Levels before = h;
      ceres::GradientProblem problem(new LevelCost(fit, prior_sd, prior, options.jobs));
      ceres::GradientProblemSolver::Options solver;
      solver.line_search_direction_type = ceres::BFGS;
      solver.max_num_iterations = iteration < 3 ? 6 : 12;
      solver.gradient_tolerance = 1e-3 * static_cast<double>(campaign.points()) / 1000.0 + 1e-2;
      solver.function_tolerance = 1e-7;
      solver.logging_type = ceres::SILENT;
      ceres::GradientProblemSolver::Summary summary;
      ceres::Solve(solver, problem, h.data(), &summary);
      fit.noise = noise_of(h, fit.noise);
      // What the recordings do not determine does not have to come to rest.
      noise_moved = (h - before).cwiseAbs().maxCoeff();
      fit.total = total_evidence(fit.stretches, fit.noise, options.jobs);
    }
    Eigen::MatrixXd M = fit.total.F;
    M.diagonal() += precision;
    Eigen::VectorXd step = M.llt().solve(fit.total.b - precision.cwiseProduct(fit.theta));
    if (const double largest = step.cwiseAbs().maxCoeff(); largest > kLargestStep) step *= kLargestStep / largest;
    parallel_for(n, options.jobs, [&](std::size_t s) {
      fit.smoothed[s] = smooth(fit.stretches[s], fit.noise, step);
      paths[s] = fit.smoothed[s].state;
    });
    fit.theta += step;
    moved = step.cwiseQuotient(prior_sd).cwiseAbs().maxCoeff();
    // Outliers are judged once, when the fit is near its end, so that hypotheses are compared on the same data.
    if (iteration == 2)
      for (std::size_t s = 0; s < n; ++s)
        for (std::size_t k = 1; k < campaign.stretches[s].size(); ++k)
          for (int i = 0; i < kShipStates; ++i)
            if (std::abs(fit.smoothed[s].innovations[k][i]) > kOutlier) {
              campaign.stretches[s].measured[k][i] = kMissing;
              ++fit.report.outliers;
            }
    if (options.progress)
      options.progress(1.0 - 1.0 / (1.0 + iteration), fmt::format("parameters still move by {:.2g} sd", moved));
  }
  parallel_for(n, options.jobs,
               [&](std::size_t s) { fit.smoothed[s] = smooth(fit.stretches[s], fit.noise, Eigen::VectorXd::Zero(p)); });

  // Standard errors of the levels from the curvature.
  const LevelCost cost(fit, prior_sd, prior, options.jobs);
  const Levels h = levels_of(fit.noise);
  constexpr double kWide = 0.2;
  std::vector<Levels> points{h};
  for (int i = 0; i < 3; ++i)
    for (const double sign : {1.0, -1.0}) points.push_back(h + sign * kWide * Levels::Unit(i));
  const std::vector<double> costs = cost.costs_at(points);
  NullFit& report = fit.report;
  for (int i = 0; i < 3; ++i) {
    const std::size_t up = 1 + 2 * static_cast<std::size_t>(i);
    const double curvature = (costs[up] + costs[up + 1] - 2.0 * costs[0]) / (kWide * kWide);
    report.sigma_w_sd[i] = fit.noise.sigma_w[i] / std::sqrt(std::max(curvature, 0.1));
  }
  Levels gradient;
  double value = 0.0;
  cost.Evaluate(h.data(), &value, gradient.data());
  report.noise_gradient = gradient.cwiseAbs().maxCoeff();
  report.sigma_w = fit.noise.sigma_w;
  report.tau_s = fit.noise.tau_s;
  report.typical = typical_acceleration(fit.stretches);
  report.step_s = campaign.step_s;
  report.samples = fit.total.measurements;
  report.log_likelihood = marginal(fit.total, fit.theta, prior_sd);
  report.log_likelihood_per_sample =
      report.log_likelihood / static_cast<double>(std::max<std::size_t>(1, report.samples));
  constexpr const char* kNames[] = {"x0_m", "y0_m", "psi_deg", "u_mps", "vm_mps", "r_degps"};
  for (int i = 0; i < kShipStates; ++i) {
    const bool measured =
        std::any_of(campaign.stretches.begin(), campaign.stretches.end(), [&](const Stretch& stretch) {
          return std::any_of(stretch.measured.begin(), stretch.measured.end(),
                             [&](const Vec6& y) { return !std::isnan(y[i]); });
        });
    if (measured)
      report.noise.push_back({kNames[i], fit.noise.measurement_sd[i] * (i == 2 || i == 5 ? 1.0 / kDegree : 1.0), 0.0});
  }
  Eigen::MatrixXd M = fit.total.F;
  M.diagonal() += prior_sd.array().square().inverse().matrix();
  const Eigen::MatrixXd covariance = M.llt().solve(Eigen::MatrixXd::Identity(p, p));
  for (Eigen::Index i = 0; i < p; ++i) {
    const double factor = std::exp(fit.theta[i]), sd = std::sqrt(covariance(i, i));
    report.parameters.push_back({fit.parameters[static_cast<std::size_t>(i)].name, factor, factor * sd, prior_sd[i],
                                 fit.theta[i] / prior_sd[i]});
  }
  return fit;
}

}  // namespace leeway::gap
