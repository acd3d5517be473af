#include "gap/show/planned_recording.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "core/units.hpp"
#include "effects/description.hpp"
#include "gap/filter/uncertainty.hpp"
#include "gap/fit/climb.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/froude_scale.hpp"

namespace leeway::gap {
namespace {

bool changes_depth(const std::string& name) { return effect_named(name).info.changes_depth; }

// What the maneuver would record if the hypothesis were true, free of noise.
std::vector<Trajectory> simulated(const MenuItem& item, const Survivor& truth, const Site& site) {
  const Eigen::Index at = truth.fit.theta.size() - 1 - truth.fit.effects;
  const Ship with = truth.hypothesis.applied_to(site.ship, truth.fit.theta.segment(at, truth.fit.effects));
  std::vector<Trajectory> result;
  for (const ManeuverRun& run : item.runs) {
    SimulatedShip start(with, item.u_mps);
    start.state.eta(2) = run.heading_rad;
    start.state.nu = water_velocity(start.model, start.state.eta, start.t_s) + Vec3<double>(item.u_mps, 0.0, 0.0);
    with.order_propulsion(item.n_rps, start.actuators);
    apply_uncertainty(start.model, without_effects(truth.fit.theta, truth.fit.effects));
    TimeGrid grid;
    grid.sample_s = site.step_s;
    grid.dt_s =
        site.step_s / std::ceil(site.step_s / (kPolicy.show.longest_step_s * FroudeScale(with.particulars.L_pp).time));
    grid.duration_s = site.step_s * std::ceil(item.each_s / site.step_s);
    const std::unique_ptr<Maneuver> maneuver = run.make(start);
    result.push_back(simulate(start, *maneuver, WindProcess(site.wind_mps), grid));
    result.back().name = result.back().file = fmt::format("{} {}", item.name, result.size());
  }
  return result;
}

// Samples of a run before it leaves the area, which may lie along the ship's first course or across it.
std::size_t samples_within(const Trajectory& run, const NextLimits& limits) {
  double low[2] = {}, high[2] = {};
  for (std::size_t k = 0; k < run.size(); ++k) {
    const double at[2] = {run[Channel::x0][k], run[Channel::y0][k]};
    for (int i = 0; i < 2; ++i) low[i] = std::min(low[i], at[i]), high[i] = std::max(high[i], at[i]);
    const double along = high[0] - low[0], across = high[1] - low[1];
    if (std::max(along, across) > *limits.length_m || std::min(along, across) > *limits.width_m) return k;
  }
  return run.size();
}

bool turns_rudders_farther(const Trajectory& run, const Ship& ship, double rudder_deg) {
  return std::ranges::any_of(ship.actuators, [&](const Actuator& actuator) {
    return info(actuator.channel).role == Role::rudder && run.has(actuator.channel) &&
           std::ranges::any_of(run[actuator.channel],
                               [&](double angle) { return std::abs(angle) > rudder_deg * kDegree; });
  });
}

// Time of a run that is within all limits, whatever is true; 0 where there is none.
double longest_s(const MenuItem& item, const std::vector<std::vector<Trajectory>>& by_truth, const Site& site) {
  const NextLimits& limits = site.limits;
  double each_s = item.each_s;
  if (limits.time_s) each_s = std::min(each_s, *limits.time_s / static_cast<double>(item.runs.size()));
  for (const std::vector<Trajectory>& runs : by_truth)
    for (const Trajectory& run : runs) {
      if (limits.rudder_deg && turns_rudders_farther(run, site.ship, *limits.rudder_deg)) return 0.0;
      if (!limits.length_m) continue;
      const std::size_t n = samples_within(run, limits);
      if (n == 0) return 0.0;
      if (n < run.size()) each_s = std::min(each_s, run[Channel::t][n - 1]);
    }
  return each_s;
}

// What is recorded of a run, and until when.
void cut(Trajectory& run, double until_s, const std::vector<Channel>& recorded) {
  const auto n = static_cast<std::ptrdiff_t>(
      std::ranges::upper_bound(run[Channel::t], until_s + kPolicy.show.time_tolerance_s) - run[Channel::t].begin());
  for (std::vector<double>& column : run.columns)
    if (std::ssize(column) > n) column.resize(static_cast<std::size_t>(n));
  for (const Channel channel : kMeasured)
    if (std::ranges::find(recorded, channel) == recorded.end()) run[channel].clear();
}

// Stretches along the states of the runs that they were made of.
std::vector<LinearStretch> along_runs(const Campaign& recorded, const std::vector<Trajectory>& runs) {
  std::vector<LinearStretch> result;
  for (const Stretch& stretch : recorded.stretches) {
    const Trajectory& run = runs[stretch.recording];
    LinearStretch& linear = result.emplace_back();
    linear.data = std::make_shared<const Stretch>(stretch);
    linear.mean_offset.assign(stretch.size(), Vec6::Zero());
    for (const double t_s : stretch.t_s) {
      const auto next = std::ranges::lower_bound(run[Channel::t], t_s - kPolicy.show.time_tolerance_s);
      const auto k = static_cast<std::size_t>(std::min(next, run[Channel::t].end() - 1) - run[Channel::t].begin());
      StateVector& x = linear.path.emplace_back(StateVector::Zero());
      for (Eigen::Index i = 0; i < kShipStates; ++i) x[i] = run[kMeasured[static_cast<std::size_t>(i)]][k];
    }
  }
  return result;
}

// What the recordings say of a hypothesis, around its parameters so far.
Evidence seen_by(const Survivor& hypothesis, const Campaign& recorded, std::vector<LinearStretch> along) {
  FittedNull fit = hypothesis.fit;
  fit.stretches = std::move(along);
  const FitOptions options;
  Climb climb(recorded, fit, hypothesis.hypothesis, options, false);
  climb.linearize_all(fit.stretches);
  return fit.total;
}

// -2 ln of how likely the best parameters make the recordings, but for what all hypotheses share.
double misfit(const Survivor& of, const Evidence& e) {
  if (!std::isfinite(e.log_likelihood)) return kPolicy.show.apart_squared;
  return -2.0 * e.log_likelihood - e.b.dot((e.F + of.precision).llt().solve(e.b));
}

}  // namespace

Survivor survivor(const Fitted& fitted, const Campaign& campaign, bool is_of_other_depth) {
  Survivor result;
  const FittedNull& fit = fitted.fit;
  result.fit.noise = fit.noise;
  result.fit.level_prior_mean = fit.level_prior_mean;
  result.fit.level_prior_sd = fit.level_prior_sd;
  const Eigen::MatrixXd M = fit.total.F + fit.prior.precision();
  const Eigen::Index coefficients = fit.theta.size() - 1 - fit.effects;

  std::vector<Eigen::Index> kept;  // places in the fit's theta; -1 for what is drawn anew
  std::vector<double> theta;
  for (Eigen::Index i = 0; i < coefficients; ++i) kept.push_back(i), theta.push_back(fit.theta[i]);
  for (const EffectSpan& span : spans_of(fitted.hypothesis)) {
    const FreeEffect& effect = fitted.hypothesis.effects[span.effect];
    if (effect.recording() && span.effects == 1) continue;  // a tug that came once
    if (is_of_other_depth && changes_depth(effect.name())) continue;
    if (span.effects > 1)
      result.hypothesis.effects.emplace_back(effect.name(), campaign.ship);
    else
      result.hypothesis.effects.push_back(effect);
    for (Eigen::Index i = 0; i < effect.size(); ++i) {
      const Eigen::VectorXd z = fit.theta.segment(coefficients + span.first, span.count);
      double mean = 0.0;
      for (std::size_t e = 0; e < span.effects; ++e)
        mean += z[static_cast<Eigen::Index>(e) * effect.size() + i] / static_cast<double>(span.effects);
      kept.push_back(span.effects > 1 ? -1 : coefficients + span.first + i);
      theta.push_back(mean);
    }
  }
  kept.push_back(fit.theta.size() - 1);
  theta.push_back(fit.theta[fit.theta.size() - 1]);

  const auto n = static_cast<Eigen::Index>(kept.size());
  result.fit.effects = n - 1 - coefficients;
  result.fit.theta = Eigen::Map<const Eigen::VectorXd>(theta.data(), n);
  result.fit.prior = ThetaPrior(Eigen::VectorXd::Ones(n));
  result.precision = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Index a = kept[static_cast<std::size_t>(i)], b = kept[static_cast<std::size_t>(j)];
      if (a >= 0 && b >= 0) result.precision(i, j) = M(a, b);
    }
  return result;
}

Site site_of(const Campaign& campaign, const NextLimits& limits) {
  Site site{campaign.ship, Vec2<double>::Zero(), {}, campaign.step_s, limits};
  double steps = 0.0;
  for (const Stretch& stretch : campaign.stretches)
    for (const auto& step : stretch.inputs) {
      site.wind_mps += step.front().start.true_wind;
      steps += 1.0;
    }
  if (steps > 0.0) site.wind_mps /= steps;
  for (const Channel channel : kMeasured)
    if (std::ranges::any_of(campaign.recordings, [&](const Trajectory& recording) { return recording.has(channel); }))
      site.recorded.push_back(channel);
  if (!limits.depth_m) return site;
  std::erase_if(site.ship.effects, [](const EffectEntry& effect) { return changes_depth(effect.type); });
  for (const EffectDescription& effect : effect_catalogue()) {
    if (!effect.info.changes_depth) continue;
    const EffectParameter& known = effect.parameters.front();
    const double h_over_T = *limits.depth_m / campaign.ship.particulars.d;
    if (h_over_T < known.prior(campaign.ship.particulars.L_pp).high)
      site.ship.effects.push_back({std::string(effect.info.name), {{std::string(known.name), h_over_T}}, "", ""});
  }
  return site;
}

std::optional<Prospect> prospect(const MenuItem& item, const std::vector<Survivor>& survivors, const Site& site) {
  try {
    std::vector<std::vector<Trajectory>> by_truth;
    by_truth.reserve(survivors.size());
    for (const Survivor& truth : survivors) by_truth.push_back(simulated(item, truth, site));
    Prospect result;
    result.each_s = std::floor(longest_s(item, by_truth, site));
    for (const std::vector<Trajectory>& runs : by_truth) {
      std::vector<Trajectory> seen = runs;
      for (Trajectory& run : seen) cut(run, result.each_s, site.recorded);
      const Campaign recorded = prepare(site.ship, std::move(seen), {site.step_s, 0.0});
      const std::vector<LinearStretch> along = along_runs(recorded, runs);
      std::vector<Evidence>& evidences = result.evidences.emplace_back();
      for (const Survivor& hypothesis : survivors) evidences.push_back(seen_by(hypothesis, recorded, along));
    }
    return result;
  } catch (const UsageError&) {  // the ship cannot do this
  } catch (const NumericalError&) {
  } catch (const InputError&) {  // nothing moves, or it is over too soon
  }
  return std::nullopt;
}

Eigen::MatrixXd squared_distances(const std::vector<Survivor>& survivors,
                                  const std::vector<const Prospect*>& recorded) {
  const auto n = static_cast<Eigen::Index>(survivors.size());
  Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    Eigen::VectorXd misfits(n);
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto truth = static_cast<std::size_t>(i), other = static_cast<std::size_t>(j);
      Evidence all(survivors[other].fit.theta.size());
      for (const Prospect* one : recorded) all += one->evidences[truth][other];
      misfits[j] = misfit(survivors[other], all);
    }
    for (Eigen::Index j = 0; j < n; ++j)
      if (j != i) apart(i, j) = std::clamp(misfits[j] - misfits[i], 0.0, kPolicy.show.apart_squared);
  }
  return 0.5 * (apart + apart.transpose());
}

}  // namespace leeway::gap
