#include "gap/fit/null_fit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/statistics.hpp"
#include "core/units.hpp"
#include "gap/filter/reference_units.hpp"
#include "gap/fit/climb.hpp"
#include "gap/fit/coefficient_scale.hpp"
#include "gap/fit/events.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// From second differences, which leave little of the ship's motion.
Noise first_noise(const Campaign& campaign) {
  Noise noise;
  const FitPolicy& of = kPolicy.fit;
  const double scale = campaign.time_scale();
  noise.sigma_w << of.first_sigma_w_mps2, of.first_sigma_w_mps2, of.first_sigma_w_mps2 / gyration_radius(campaign.ship);
  noise.tau_s = of.first_tau_s * scale;
  // Shorter is noise of the sensors, longer a force that has a cause.
  noise.least_tau_s = of.least_tau_s * scale;
  noise.longest_tau_s = of.longest_tau_s * scale;
  noise.wind_tau_s = of.wind_tau_s * scale;
  noise.least_measurement_sd = least_measurement_sd(campaign.ship);
  Vec6 least = Eigen::Map<const Vec6>(of.least_first_sd.data());
  least.head<2>() *= scale * scale;
  least.segment<2>(3) *= scale;
  least[5] /= scale;
  for (int i = 0; i < kShipStates; ++i) {
    std::vector<double> differences;
    for (const Stretch& stretch : campaign.stretches) {
      std::vector<std::size_t> known;
      for (std::size_t k = 0; k < stretch.size(); ++k) {
        if (std::isnan(stretch.measured[k][i])) continue;
        known.push_back(k);
        const std::size_t n = known.size();
        if (n < 3 || known[n - 1] - known[n - 2] != known[n - 2] - known[n - 3]) continue;
        differences.push_back(stretch.measured[k][i] - 2.0 * stretch.measured[known[n - 2]][i] +
                              stretch.measured[known[n - 3]][i]);
      }
    }
    noise.measurement_sd[i] = std::max(robust_sd(differences) / std::sqrt(6.0), least[i]);
  }
  noise.measurement_sd.head<2>().setConstant(noise.measurement_sd.head<2>().maxCoeff());
  return noise;
}

// Where theta has moved a parameter, with what is left of its uncertainty.
ParameterShift shift_of(const UncertainParameter& parameter, double theta, double sd) {
  if (!parameter.is_absolute) {
    const double factor = std::exp(theta);
    return {parameter.name, factor, factor * sd, parameter.sd, theta / parameter.sd, std::nullopt};
  }
  const double value = parameter.value.value_or(0.0);
  return {parameter.name,       1.0 + theta / value,
          sd / std::abs(value), 0.0,
          theta / parameter.sd, ParameterShift::Difference{theta, sd, parameter.sd}};
}

// Standard errors of the levels from the curvature.
void judge_levels(const LevelProblem& problem, FittedNull& fit) {
  NullFit& report = fit.report;
  const Levels h = levels_of(fit.noise);
  std::vector<Levels> points{h};
  for (int i = 0; i < 3; ++i)
    for (const double sign : {1.0, -1.0})
      points.push_back(h + sign * kPolicy.fit.level_curvature_step * Levels::Unit(i));
  const std::vector<double> costs = problem.costs(points);
  for (int i = 0; i < 3; ++i) {
    const std::size_t up = 1 + 2 * static_cast<std::size_t>(i);
    const double curvature = (costs[up] + costs[up + 1] - 2.0 * costs[0]) /
                             (kPolicy.fit.level_curvature_step * kPolicy.fit.level_curvature_step);
    report.sigma_w_sd[i] = fit.noise.sigma_w[i] / std::sqrt(std::max(curvature, kPolicy.fit.least_level_curvature));
  }
  report.noise_gradient = problem.gradient(h);
}

// What is reported of a fit: smoothed paths, shifts, and where asked for how well the noise levels are known.
void finish(const Campaign& campaign, const Climb& climb, std::size_t jobs, bool judges_levels, FittedNull& fit) {
  const Eigen::Index p = fit.theta.size();
  parallel_for(fit.stretches.size(), jobs,
               [&](std::size_t s) { fit.smoothed[s] = smooth(fit.stretches[s], fit.noise, Eigen::VectorXd::Zero(p)); });

  NullFit& report = fit.report;
  if (judges_levels) judge_levels(climb.levels(), fit);
  report.sigma_w = fit.noise.sigma_w;
  report.is_noise_free =
      (fit.noise.measurement_sd.array() <= (1.0 + kPolicy.fit.at_bound) * fit.noise.least_measurement_sd.array())
          .tail<3>()
          .all();
  report.tau_s = fit.noise.tau_s;
  report.coefficient_scale = fit.scale;
  if (campaign.has_wind) report.wind_share = fit.noise.wind_share;
  if (fit.noise.one_receiver) report.receiver = {fit.noise.receiver_sd, fit.noise.receiver_tau_s};
  // In a straight run nothing is accelerated: that the simulator errs by as much says nothing there.
  report.typical = typical_acceleration(fit.stretches).cwiseMax(reference_acceleration(campaign.ship));
  report.step_s = campaign.step_s;
  report.samples = fit.total.measurements;
  report.log_likelihood = marginal(fit.total, fit.theta, fit.prior);
  report.log_likelihood_per_sample =
      report.log_likelihood / static_cast<double>(std::max<std::size_t>(1, report.samples));
  constexpr const char* kNames[] = {"x0_m", "y0_m", "psi_deg", "u_mps", "vm_mps", "r_degps"};
  for (int i = 0; i < kShipStates; ++i) {
    const bool measured = std::any_of(fit.stretches.begin(), fit.stretches.end(), [&](const LinearStretch& stretch) {
      return std::any_of(stretch.data->measured.begin(), stretch.data->measured.end(),
                         [&](const Vec6& y) { return !std::isnan(y[i]); });
    });
    if (measured)
      report.noise.push_back(
          {kNames[i], fit.noise.measurement_sd[i] * (i == 2 || i == 5 ? 1.0 / kDegree : 1.0), kMissing});
  }
  const Eigen::MatrixXd covariance = posterior_covariance(fit);
  for (Eigen::Index i = 0; i < fit.coefficients(); ++i) {
    report.parameters.push_back(
        shift_of(fit.parameters[static_cast<std::size_t>(i)], fit.theta[i], std::sqrt(covariance(i, i))));
  }
  report.actuator_lag = {"actuator_lag", kPolicy.filter.timing_share * fit.theta[p - 1],
                         kPolicy.filter.timing_share * std::sqrt(covariance(p - 1, p - 1))};
}

void take(const PriorWidths& widths, FittedNull& fit) {
  fit.prior = widths.prior;
  fit.scale = widths.scale;
}

// With the coefficients as uncertain as stated, then at the common scale that is likeliest.
void fit_from_stated(Climb& climb, const FitOptions& options, FittedNull& fit) {
  fit.prior = fit.stated;
  fit.scale = 1.0;
  const bool converged_as_stated = climb.until_converged(options.most_iterations, Judged::all);
  const NullFit as_stated = fit.report;
  const Eigen::VectorXd theta = fit.theta;
  const Noise noise = fit.noise;
  std::vector<std::vector<StateVector>> paths;
  for (const LinearStretch& stretch : fit.stretches) paths.push_back(stretch.path);
  // Wider, data that fit badly can lead anywhere. Then the parameters stay where the stated uncertainty holds them.
  take(file_evidence(fit.total, fit.theta, widths_by_scale(fit.stated, fit.parameters, fit.effects)).likeliest, fit);
  fit.report.converged = climb.until_converged(options.most_iterations / 2, Judged::nothing);
  if (!fit.report.converged) {
    const int iterations = fit.report.iterations;
    fit.report = as_stated;
    fit.report.iterations = iterations;
    fit.report.converged = converged_as_stated;
    fit.theta = theta;
    fit.noise = noise;
    for (std::size_t s = 0; s < paths.size(); ++s) fit.stretches[s].path = std::move(paths[s]);
    climb.linearize_all(fit.stretches);
  }
}

}  // namespace

namespace {

bool is_as_fast_as_allowed(const Noise& noise) {
  return noise.tau_s < (1.0 + kPolicy.fit.at_bound) * noise.least_tau_s;
}

// Levels at which the recordings are likelier if positions and velocities err together: by one receiver, or one derived
// from the other. A model error that changes as fast as is allowed is noise of the sensors, in part at least.
std::optional<Noise> with_one_receiver(const Campaign& campaign, const Climb& climb, const FittedNull& fit) {
  if (fit.noise.one_receiver || !is_as_fast_as_allowed(fit.noise) || !campaign.has_position) return std::nullopt;
  LevelProblem problem = climb.levels();
  const Levels now = levels_of(fit.noise);
  const double before = problem.costs({now}).front();
  problem.like.one_receiver = true;
  problem.free.insert(problem.free.end(), {kReceiverLevel, kReceiverLevel + 1});
  Levels start = now;
  LevelCurvature curvature = LevelCurvature::Identity();
  start.head<2>().array() -= std::log(kPolicy.fit.less_error_with_receiver);
  const Levels best = problem.minimize(start, static_cast<int>(kPolicy.fit.receiver_steps), curvature);
  if (problem.costs({best}).front() >= before) return std::nullopt;
  return noise_of(best, problem.like);
}

// Continues from other levels of the noise. Outliers stay what they are, so that likelihoods compare.
FittedNull continued(const Campaign& campaign, const FitOptions& options, FittedNull fit, Judged judged) {
  const Hypothesis nothing;
  Climb climb(campaign, fit, nothing, options, true);
  fit.report.converged = climb.until_converged(options.most_iterations, judged);
  take(file_evidence(fit.total, fit.theta, widths_by_scale(fit.stated, fit.parameters, fit.effects)).likeliest, fit);
  fit.report.converged &= climb.until_converged(options.most_iterations / 2, Judged::nothing);
  return fit;
}

// With a receiver's error there are two optima: a model error that changes as fast as is allowed beside a small one of
// the receiver, and a slow one beside a large one. The likelier.
void take_likelier_optimum(const Campaign& campaign, const FitOptions& options, FittedNull& fit) {
  FittedNull start = fit;
  const bool is_fast = is_as_fast_as_allowed(fit.noise);
  start.noise.tau_s = is_fast ? std::sqrt(fit.noise.least_tau_s * fit.noise.longest_tau_s) : fit.noise.least_tau_s;
  start.noise.sigma_w.head<2>() *=
      is_fast ? 1.0 / kPolicy.fit.less_error_with_receiver : kPolicy.fit.less_error_with_receiver;
  start.level_curvature.setIdentity();
  FittedNull other = continued(campaign, options, std::move(start), Judged::events);
  if (other.report.converged && log_evidence(other) > log_evidence(fit)) fit = std::move(other);
}

// The fit with a receiver's error, where the recordings are likelier so.
void fit_receiver(const Campaign& campaign, const FitOptions& options, const Climb& climb, FittedNull& fit) {
  if (const std::optional<Noise> noise = with_one_receiver(campaign, climb, fit)) {
    FittedNull start = fit;
    start.noise = *noise;
    FittedNull other = continued(campaign, options, std::move(start), Judged::all);
    if (log_evidence(other) >= log_evidence(fit)) fit = std::move(other);
  }
  if (fit.noise.one_receiver) take_likelier_optimum(campaign, options, fit);
}

}  // namespace

FittedNull fit_null(const Campaign& campaign, const FitOptions& options, const FittedNull* near_by) {
  FittedNull fit;
  if (campaign.ensemble)
    fit.parameters = {timing_parameter()};  // what the ensemble may err by is its members' spread
  else
    fit.parameters = uncertain_parameters(campaign.ship);
  fit.stated = campaign.ensemble ? ThetaPrior(Eigen::VectorXd::Constant(1, fit.parameters.back().sd))
                                 : ThetaPrior(coefficient_law(campaign.ship), fit.parameters.back().sd);
  fit.faults = static_cast<Eigen::Index>(campaign.free_faults.size());
  const Eigen::Index coefficients = fit.stated.size() - 1;
  fit.parameters.insert(fit.parameters.end() - 1, campaign.free_faults.begin(), campaign.free_faults.end());
  fit.stated = fit.stated.with(coefficients, Eigen::VectorXd::Ones(fit.faults));
  const auto p = static_cast<Eigen::Index>(fit.parameters.size());
  fit.theta = Eigen::VectorXd::Zero(p);
  fit.noise = first_noise(campaign);
  // Weak knowledge that keeps levels finite where the recordings say nothing. Model errors of model ships are around
  // 5e-4 m/s^2, and accelerations are the same at any scale; within a factor of 20.
  fit.level_prior_mean = levels_of(fit.noise);
  fit.level_prior_mean.head<3>().setConstant(std::log(kPolicy.detect.reference_acceleration_mps2));
  fit.level_prior_mean[2] -= std::log(gyration_radius(campaign.ship));
  fit.level_prior_sd.setConstant(kPolicy.fit.level_prior_sd);
  fit.level_prior_sd[kTauLevel] = kPolicy.fit.tau_prior_sd;
  fit.level_prior_sd[kWindLevel] = kPolicy.fit.wind_prior_sd;
  if (near_by) {
    fit.theta << near_by->theta.head(coefficients), Eigen::VectorXd::Zero(fit.faults), near_by->theta.tail(1);
    fit.noise = near_by->noise;
  }

  const Hypothesis nothing;
  Climb climb(campaign, fit, nothing, options, true);
  if (near_by) {
    fit.prior =
        near_by->prior.without(coefficients, near_by->faults).with(coefficients, Eigen::VectorXd::Ones(fit.faults));
    fit.scale = near_by->scale;
    // Outliers are judged by its noise: levels that moved first would hide them.
    try {
      fit.report.converged =
          climb.until_converged(options.most_iterations / 2, Judged::all, kPolicy.fit.outliers_at.front() + 1);
    } catch (const NumericalError&) {  // with its coefficients the simulator runs away along the measurements
      return fit_null(campaign, options);
    }
  }
  if (!fit.report.converged) fit_from_stated(climb, options, fit);
  fit_receiver(campaign, options, climb, fit);
  const Climb there(campaign, fit, nothing, options, true);
  finish(campaign, there, options.jobs, true, fit);
  return fit;
}

FittedNull fit_with(const Campaign& campaign, const FittedNull& from, const Hypothesis& hypothesis,
                    const Eigen::VectorXd& theta0, const FitOptions& options) {
  FittedNull fit = from;
  const Eigen::Index effects = hypothesis.size(), coefficients = from.theta.size() - 1 - from.effects;
  fit.effects = effects;
  fit.theta = theta0;
  const auto beside = [&](const ThetaPrior& prior) {
    return prior.without(coefficients, from.effects).with(coefficients, Eigen::VectorXd::Ones(effects));
  };
  fit.stated = beside(from.stated);
  fit.prior = beside(from.prior);
  fit.parameters.erase(fit.parameters.begin() + coefficients, fit.parameters.end() - 1);
  for (const FreeEffect& effect : hypothesis.effects)
    for (Eigen::Index i = 0; i < effect.size(); ++i)
      fit.parameters.insert(fit.parameters.end() - 1, {fmt::format("{}.z{}", effect.name(), i + 1), 1.0});
  fit.report = NullFit();
  fit.report.outliers = from.report.outliers;
  Climb climb(campaign, fit, hypothesis, options, false);
  fit.report.converged = climb.until_converged(options.most_iterations, Judged::events);
  finish(campaign, climb, options.jobs, false, fit);
  climb.restore_inputs();
  return fit;
}

Campaign without_outliers(Campaign campaign, const FittedNull& fit) {
  for (std::size_t s = 0; s < fit.stretches.size(); ++s)
    campaign.stretches[s].measured = fit.stretches[s].data->measured;
  return campaign;
}

FittedNull follow(const Campaign& campaign, const FittedNull& fit, const Hypothesis& hypothesis, std::size_t jobs) {
  FittedNull result = fit;
  result.stretches.clear();
  result.smoothed.clear();
  result.event_scale.clear();
  FitOptions options;
  options.jobs = jobs;
  Climb climb(campaign, result, hypothesis, options, false);
  climb.linearize_all(result.stretches);  // along the measurements
  climb.linearize_all(result.stretches);
  const Eigen::VectorXd there = Eigen::VectorXd::Zero(fit.theta.size());
  parallel_for(result.stretches.size(), jobs,
               [&](std::size_t s) { result.smoothed[s] = smooth(result.stretches[s], result.noise, there); });
  climb.restore_inputs();
  return result;
}

double log_evidence(const FittedNull& fit) {
  const Levels off = (levels_of(fit.noise) - fit.level_prior_mean).cwiseQuotient(fit.level_prior_sd);
  return file_evidence(fit.total, fit.theta, widths_by_scale(fit.stated, fit.parameters, fit.effects)).log_evidence -
         0.5 * off.squaredNorm() + fit.log_prior_of_events;
}

Eigen::MatrixXd posterior_covariance(const FittedNull& fit) {
  const Eigen::MatrixXd M = fit.total.F + fit.prior.precision();
  return M.llt().solve(Eigen::MatrixXd::Identity(M.rows(), M.cols()));
}

Coordinates coordinates_of(const FittedNull& fit) {
  const Eigen::Index effects = fit.effects, first = fit.theta.size() - 1 - effects;
  return {fit.theta.segment(first, effects), posterior_covariance(fit).block(first, first, effects, effects)};
}

// Before any recording was seen each is standard normal, by itself: the posterior's precision less 1.
Coordinates without_prior(const Coordinates& z) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(z.mean.size(), z.mean.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> recorded(
      Eigen::MatrixXd(Eigen::LLT<Eigen::MatrixXd>(z.covariance).solve(one)) - one);
  const double least = 1.0 / (kPolicy.fit.farthest * kPolicy.fit.farthest);
  const Eigen::VectorXd variance = recorded.eigenvalues().cwiseMax(least).cwiseInverse();
  const Eigen::MatrixXd covariance =
      recorded.eigenvectors() * variance.asDiagonal() * recorded.eigenvectors().transpose();
  return {z.mean + covariance * z.mean, covariance};
}

}  // namespace leeway::gap
