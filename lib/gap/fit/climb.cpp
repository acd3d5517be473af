#include "gap/fit/climb.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/statistics.hpp"
#include "gap/fit/events.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// The measured velocity that is farthest from what is usual in the stretch: "u_mps is 20 at 45 s".
std::string farthest_measurement(const Stretch& stretch) {
  std::string result;
  double most = 0.0;
  for (int i = 3; i < kShipStates; ++i) {
    std::vector<double> known;
    for (const Vec6& y : stretch.measured)
      if (!std::isnan(y[i])) known.push_back(y[i]);
    const double usual = median(known);
    for (double& x : known) x -= usual;
    const double sd = std::max(robust_sd(std::move(known)), kPolicy.filter.tiny);
    for (std::size_t k = 0; k < stretch.size(); ++k)
      if (const double off = std::abs(stretch.measured[k][i] - usual) / sd; off > most) {
        most = off;
        const Channel channel = kMeasured[static_cast<std::size_t>(i)];
        result =
            fmt::format("{} is {:.4g} at {:.4g} s, usually {:.4g}", column_name(channel),
                        stretch.measured[k][i] / column_unit(channel), stretch.t_s[k], usual / column_unit(channel));
      }
  }
  return result;
}

}  // namespace

std::vector<EffectColumns> columns_by_recording(const Campaign& campaign, const Hypothesis& hypothesis,
                                                const Eigen::VectorXd& z, const Eigen::VectorXd& plain_theta) {
  std::vector<EffectColumns> result;
  for (std::size_t r = 0; r < campaign.recordings.size(); ++r)
    result.emplace_back(campaign, hypothesis, z, plain_theta, r);
  return result;
}

Climb::Climb(const Campaign& campaign, FittedNull& fit, const Hypothesis& hypothesis, const FitOptions& options,
             bool knows_sensors)
    : campaign_(campaign),
      fit_(fit),
      hypothesis_(hypothesis),
      options_(options),
      free_levels_(free_levels(knows_sensors, campaign.has_wind, fit.noise.one_receiver)) {
  fit.stretches.resize(campaign.stretches.size());
  fit.smoothed.resize(campaign.stretches.size());
  fit.event_scale.resize(campaign.stretches.size());
  acting_.resize(campaign.stretches.size());
  for (std::size_t s = 0; s < campaign.stretches.size(); ++s)
    own_.push_back(fit.stretches[s].data ? fit.stretches[s].data
                                         : std::make_shared<const Stretch>(campaign.stretches[s]));
}

LevelProblem Climb::levels() const {
  return {fit_.stretches,      fit_.theta,   fit_.prior,   ExtraColumns{0, nullptr}, fit_.noise, fit_.level_prior_mean,
          fit_.level_prior_sd, free_levels_, options_.jobs};
}

void Climb::linearize_all(const std::vector<LinearStretch>& before, std::size_t neighbors) {
  const Eigen::Index effects = fit_.effects;
  const Eigen::VectorXd plain = without_effects(fit_.theta, effects);
  if (campaign_.ensemble) return linearize_ensemble(before, neighbors);
  const std::vector<EffectColumns> by_recording =
      columns_by_recording(campaign_, hypothesis_, fit_.theta.segment(plain.size() - 1, effects), plain);
  parallel_for(fit_.stretches.size(), options_.jobs, [&](std::size_t s) {
    const EffectColumns& columns = by_recording[own_[s]->recording];
    const std::shared_ptr<const Stretch> acting = acting_as(columns, s);
    if (before[s].data == nullptr)
      fit_.stretches[s] = linearize(columns.ship(), acting, measured_path(*acting, neighbors), plain);
    else
      fit_.stretches[s] = linearize_filtered(columns.ship(), before[s], acting, fit_.noise, fit_.event_scale[s], plain);
    if (effects > 0) columns.add_to(fit_.stretches[s]);
  });
  judge_all();
}

// Along the measurements at first; where the simulator runs away along a few that are far off, along what those around
// them say: outliers are judged by what it predicts there.
void Climb::begin() {
  const bool is_first = std::ranges::any_of(fit_.stretches, [](const LinearStretch& s) { return s.data == nullptr; });
  linearize_all(fit_.stretches);
  if (is_first && !follows())
    linearize_all(std::vector<LinearStretch>(fit_.stretches.size()), kPolicy.fit.path_neighbors);
}

void Climb::linearize_anew() {
  std::vector<LinearStretch> before(fit_.stretches.size());
  std::swap(before, fit_.stretches);
  linearize_all(before);
  if (follows()) return;
  std::swap(before, fit_.stretches);
  fit_.total = levels().total(fit_.noise);
}

bool Climb::until_converged(int most_iterations, Judged judged, std::int64_t levels_from) {
  const bool judges = judged == Judged::all;
  double moved = 1.0, noise_moved = 1.0, damping = 0.0;
  bool looks_for_events = judged != Judged::nothing, has_needless_events = true;
  for (int iteration = 0;; ++iteration, ++fit_.report.iterations) {
    const bool is_free = judges && iteration < kPolicy.fit.free_steps;
    if (iteration == 0)
      begin();
    else if (judges)
      linearize_anew();
    if (!follows()) throw NumericalError(diverged());
    const Eigen::VectorXd slope = slope_now();
    double& distance = fit_.report.distance;
    fit_.report.gradient = slope.cwiseProduct(fit_.prior.sd()).cwiseAbs().maxCoeff();
    distance = distance_now();
    const bool stands =
        iteration > 1 && moved < kPolicy.fit.theta_converged && noise_moved < kPolicy.fit.noise_converged;
    const bool is_there = stands && (distance < kPolicy.fit.near_sd || moved == 0.0);
    if (iteration == most_iterations) return stands && distance < kPolicy.fit.far_sd;
    if (is_there || (looks_for_events && iteration == kPolicy.fit.events_fixed)) {
      looks_for_events = false;
      has_needless_events = has_needless_events && leave_out_needless_events();
      if (has_needless_events)
        noise_moved = moved = 1.0;
      else if (is_there)
        return distance < kPolicy.fit.far_sd;
    }

    // Noise levels, later few steps, since parameters follow.
    if ((!judges || iteration >= levels_from) &&
        (noise_moved > kPolicy.fit.noise_converged || moved > kPolicy.fit.theta_nearly_converged)) {
      const Levels before = levels_of(fit_.noise);
      fit_.noise = noise_of(levels().minimize(before, is_free ? 5 : 2, fit_.level_curvature), fit_.noise);
      noise_moved = (levels_of(fit_.noise) - before).cwiseAbs().maxCoeff();
      fit_.total = levels().total(fit_.noise);
    }
    // Far from the best noise levels likelihoods say little, and about the measurements' path nothing.
    moved = step(damping, is_free).cwiseQuotient(fit_.prior.sd()).cwiseAbs().maxCoeff();
    parallel_for(fit_.stretches.size(), options_.jobs, [&](std::size_t s) {
      fit_.smoothed[s] = smooth(fit_.stretches[s], fit_.noise, Eigen::VectorXd::Zero(fit_.theta.size()));
      if (!judges) return;
      const std::size_t first = std::min(kPolicy.filter.first_points, fit_.smoothed[s].state.size());
      std::copy_n(fit_.smoothed[s].state.begin(), first, fit_.stretches[s].path.begin());
    });
    if (looks_for_events && iteration > 1) {
      find_events(fit_, campaign_);
      if (!judges) take_events();
    }
    // Once more when events no longer hide them.
    if (judges && std::ranges::count(kPolicy.fit.outliers_at, iteration) > 0) leave_out_outliers();
    if (options_.progress)
      options_.progress(1.0 - 1.0 / (1.0 + 0.3 * fit_.report.iterations),
                        fmt::format("parameters still move by {:.2g} sd", moved));
  }
}

void Climb::take_events() {
  for (std::size_t s = 0; s < fit_.stretches.size(); ++s) fit_.stretches[s].event_scale = fit_.event_scale[s];
  fit_.total = levels().total(fit_.noise);
}

void Climb::restore_inputs() {
  for (std::size_t s = 0; s < own_.size(); ++s) fit_.stretches[s].data = own_[s];
}

// The stretch with the inputs as the rudders follow them there.
std::shared_ptr<const Stretch> Climb::acting_as(const EffectColumns& columns, std::size_t s) {
  if (columns.response() != responses_[s]) {
    const auto acting = std::make_shared<Stretch>(*own_[s]);
    columns.set_inputs_of(*acting);
    acting_[s] = acting;
    responses_[s] = columns.response();
  }
  return responses_[s] == own_response_ ? own_[s] : acting_[s];
}

// Which recording the simulator cannot follow at all.
std::string Climb::diverged() const {
  std::string text = "the simulator runs away along the recordings, whose inputs or states are far from what it knows";
  for (std::size_t s = 0; s < fit_.stretches.size(); ++s)
    if (!std::isfinite(evidence(fit_.stretches[s], fit_.noise).log_likelihood)) {
      const Stretch& stretch = campaign_.stretches[s];
      text = fmt::format("{}: {} between {:.4g} and {:.4g} s: {}", campaign_.recordings[stretch.recording].file, text,
                         stretch.t_s.front(), stretch.t_s.back(), farthest_measurement(stretch));
      break;
    }
  for (const std::string& notice : campaign_.notices) text += "; " + notice;
  return text;
}

void Climb::linearize_ensemble(const std::vector<LinearStretch>& before, std::size_t neighbors) {
  const EnsembleSimulator& ensemble = *campaign_.ensemble;
  parallel_for(fit_.stretches.size(), options_.jobs, [&](std::size_t s) {
    fit_.stretches[s] =
        before[s].data == nullptr
            ? linearize(ensemble, own_[s], measured_path(*own_[s], neighbors), fit_.theta)
            : linearize_filtered(ensemble, before[s], own_[s], fit_.noise, fit_.event_scale[s], fit_.theta);
  });
  judge_all();
}

void Climb::judge_all() {
  fit_.noise.least_sigma_w = kPolicy.fit.least_error * typical_acceleration(fit_.stretches);
  fit_.total = levels().total(fit_.noise);
}

Eigen::MatrixXd Climb::curvature_now() const { return fit_.total.F + fit_.prior.precision(); }

bool Climb::follows() const { return std::isfinite(fit_.total.log_likelihood) && fit_.total.b.allFinite(); }

// From where the slope vanishes, in posterior standard deviations.
double Climb::distance_now() const {
  const Eigen::VectorXd slope = slope_now();
  return std::sqrt(std::max(0.0, slope.dot(curvature_now().llt().solve(slope))));
}

double Climb::log_posterior() const {
  return fit_.total.log_likelihood - 0.5 * fit_.theta.dot(fit_.prior.pull(fit_.theta));
}

// A Gauss-Newton step of theta, shortened by 1 + damping, until it makes what was recorded more likely, unless
// `anyhow`; zero where none does. Kinks of the model, and a filter that gets to know other paths, let full steps lead
// away.
Eigen::VectorXd Climb::step(double& damping, bool anyhow) {
  const Eigen::VectorXd theta = fit_.theta, slope = slope_now();
  const Eigen::MatrixXd M = curvature_now();
  const Evidence total = fit_.total;
  const double before = log_posterior(), distance = distance_now();
  const Eigen::VectorXd newton = M.llt().solve(slope);
  if (!newton.allFinite()) return Eigen::VectorXd::Zero(theta.size());
  std::vector<LinearStretch> stretches(fit_.stretches.size());
  std::swap(stretches, fit_.stretches);
  const Eigen::Index effects = fit_.effects, coefficients = theta.size() - 1 - effects;
  for (;;) {
    Eigen::VectorXd step = newton;
    double too_long =
        std::max({1.0 + damping, step.head(coefficients).lpNorm<Eigen::Infinity>() / kPolicy.fit.largest_step,
                  std::abs(step[step.size() - 1]) / kPolicy.fit.largest_timing_step});
    if (effects > 0)
      too_long = std::max(too_long,
                          step.segment(coefficients, effects).cwiseAbs().maxCoeff() / kPolicy.fit.largest_effect_step);
    step /= too_long;
    fit_.theta = theta + step;
    linearize_all(stretches);
    // Never, where the simulator runs away.
    if (follows() && (anyhow || log_posterior() > before + kPolicy.fit.least_gain ||
                      distance_now() < kPolicy.fit.nearer * distance)) {
      const double expected = slope.dot(step) - 0.5 * step.dot(M * step), gained = log_posterior() - before;
      if (expected > kPolicy.fit.measurable_gain && gained < kPolicy.fit.poor_step * expected)
        damping = std::max(kPolicy.fit.damping_factor * damping, kPolicy.fit.least_damping);
      else if (expected <= kPolicy.fit.measurable_gain || gained > kPolicy.fit.good_step * expected)
        damping = damping > kPolicy.fit.least_damping ? damping / kPolicy.fit.damping_factor : 0.0;
      return step;
    }
    damping = std::max(kPolicy.fit.damping_factor * damping, kPolicy.fit.least_damping);
    if (damping > kPolicy.fit.most_damping) break;
  }
  damping = kPolicy.fit.least_damping;
  fit_.theta = theta;
  fit_.total = total;
  std::swap(stretches, fit_.stretches);
  return Eigen::VectorXd::Zero(theta.size());
}

// Events that gain less than they cost: all, where other levels of the noise do as well, or each by itself. Whether
// there were any.
bool Climb::leave_out_needless_events() {
  const std::vector<Event> events = events_of(fit_, campaign_);
  if (events.empty()) return false;
  const auto found = fit_.event_scale;
  const Noise noise = fit_.noise;
  const double cost = fit_.log_prior_of_events;
  double best = log_evidence(fit_);
  for (const Event& event : events) leave_out(event, fit_);
  take_events();
  fit_.noise = noise_of(levels().minimize(levels_of(noise), 5, fit_.level_curvature), noise);
  fit_.total = levels().total(fit_.noise);
  if (log_evidence(fit_) > best) return true;
  fit_.event_scale = found;
  fit_.log_prior_of_events = cost;
  fit_.noise = noise;
  bool is_any_needless = false;
  for (const Event& event : events) {
    const std::vector<Vec3<double>> scales = fit_.event_scale[event.stretch];
    leave_out(event, fit_);
    take_events();
    if (const double without = log_evidence(fit_); without > best) {
      best = without;
      is_any_needless = true;
      continue;
    }
    fit_.event_scale[event.stretch] = scales;
    fit_.log_prior_of_events += event.log_prior;
  }
  take_events();
  return is_any_needless;
}

void Climb::leave_out_outliers() {
  const std::vector<std::shared_ptr<const Stretch>> judged = without_outliers(fit_);
  for (std::size_t s = 0; s < own_.size(); ++s)
    if (judged[s]) fit_.stretches[s].data = own_[s] = judged[s];
}

}  // namespace leeway::gap
