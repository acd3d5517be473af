#include "gap/show/next_maneuver.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "core/units.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/froude_scale.hpp"
#include "gap/show/maneuver_menu.hpp"

namespace leeway::gap {
namespace {

// A hypothesis as it would stand in a recording that nobody has seen: what differed between recordings is a draw from
// what was known before.
struct Survivor {
  Hypothesis hypothesis;
  FittedNull fit;  // theta and what goes with it, without stretches
  Eigen::MatrixXd precision;
};

Survivor survivor(const Fitted& fitted, const Campaign& campaign) {
  Survivor result;
  const FittedNull& fit = fitted.fit;
  result.fit.noise = fit.noise;
  result.fit.level_prior_mean = fit.level_prior_mean;
  result.fit.level_prior_sd = fit.level_prior_sd;
  Eigen::MatrixXd M = fit.total.F;
  M.diagonal() += fit.prior_sd.array().square().inverse().matrix();
  const Eigen::Index coefficients = fit.theta.size() - 1 - fit.effects;

  std::vector<Eigen::Index> kept;  // places in the fit's theta; -1 for what is drawn anew
  std::vector<double> theta;
  for (Eigen::Index i = 0; i < coefficients; ++i) kept.push_back(i), theta.push_back(fit.theta[i]);
  for (const EffectSpan& span : spans_of(fitted.hypothesis)) {
    const FreeEffect& effect = fitted.hypothesis.effects[span.effect];
    if (effect.recording() && span.effects == 1) continue;  // a tug that came once
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
  result.fit.prior_sd = Eigen::VectorXd::Ones(n);
  result.precision = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Index a = kept[static_cast<std::size_t>(i)], b = kept[static_cast<std::size_t>(j)];
      if (a >= 0 && b >= 0) result.precision(i, j) = M(a, b);
    }
  return result;
}

// What the maneuver would record if the hypothesis were true, free of noise.
std::vector<Trajectory> simulated(const MenuItem& item, const Survivor& truth, const Ship& ship,
                                  const Vec2<double>& wind, double step_s) {
  const Eigen::Index at = truth.fit.theta.size() - 1 - truth.fit.effects;
  const Ship with = truth.hypothesis.applied_to(ship, truth.fit.theta.segment(at, truth.fit.effects));
  const Actuators<double> ahead = steady_ahead(ship, ship.u0_mps).actuators;
  std::vector<Trajectory> result;
  for (const ManeuverRun& run : item.runs) {
    SimulatedShip start(with);
    start.state.eta(2) = run.heading_rad;
    start.actuators = ahead;
    apply_uncertainty(start.model, without_effects(truth.fit.theta, truth.fit.effects));
    TimeGrid grid;
    grid.sample_s = step_s;
    grid.dt_s = step_s / std::ceil(step_s / (kPolicy.show.longest_step_s * FroudeScale(ship.particulars.L_pp).time));
    grid.duration_s = step_s * std::ceil(item.each_s / step_s);
    const std::unique_ptr<Maneuver> maneuver = run.make(start);
    result.push_back(simulate(start, *maneuver, WindProcess(wind), grid));
    result.back().name = result.back().file = fmt::format("{} {}", item.name, result.size());
  }
  return result;
}

Vec2<double> mean_wind(const Campaign& campaign) {
  Vec2<double> sum = Vec2<double>::Zero();
  double n = 0.0;
  for (const Stretch& stretch : campaign.stretches)
    for (const auto& step : stretch.inputs) {
      sum += step.front().start.true_wind;
      n += 1.0;
    }
  return n > 0.0 ? Vec2<double>(sum / n) : sum;
}

// -2 ln of how likely the best parameters of `other` make the recordings, but for what all hypotheses share.
double misfit(const Campaign& campaign, const Survivor& other) {
  const FittedNull there = follow(campaign, other.fit, other.hypothesis, 1);
  const Evidence& e = there.total;
  if (!std::isfinite(e.log_likelihood)) return kPolicy.show.apart_squared;
  return -2.0 * e.log_likelihood - e.b.dot((e.F + other.precision).llt().solve(e.b));
}

// How far the hypotheses are from each other after a maneuver; nothing where the ship cannot do it.
std::optional<Eigen::MatrixXd> squared_distances(const MenuItem& item, const std::vector<Survivor>& survivors,
                                                 const Campaign& campaign, const Vec2<double>& wind) {
  const auto n = static_cast<Eigen::Index>(survivors.size());
  Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Survivor& truth = survivors[static_cast<std::size_t>(i)];
    std::optional<Campaign> recorded;
    try {
      recorded =
          prepare(campaign.ship, simulated(item, truth, campaign.ship, wind, campaign.step_s), {campaign.step_s, 0.0});
    } catch (const UsageError&) {  // the ship cannot do this
      return std::nullopt;
    } catch (const NumericalError&) {
      return std::nullopt;
    } catch (const InputError&) {  // nothing moves
      return std::nullopt;
    }
    const double right = misfit(*recorded, truth);
    for (Eigen::Index j = 0; j < n; ++j)
      if (j != i)
        apart(i, j) = std::clamp(misfit(*recorded, survivors[static_cast<std::size_t>(j)]) - right, 0.0,
                                 kPolicy.show.apart_squared);
  }
  return 0.5 * (apart + apart.transpose());
}

}  // namespace

Recommended recommended(const std::vector<NextManeuver>& maneuvers, double p_right, const Policy& policy) {
  std::optional<std::size_t> shortest;
  for (std::size_t i = 0; i < maneuvers.size(); ++i)
    if (maneuvers[i].p_right >= policy.show.decisive &&
        (!shortest || maneuvers[i].duration_s < maneuvers[*shortest].duration_s))
      shortest = i;
  const std::size_t place = shortest.value_or(0);
  return {place, maneuvers.at(place).p_right > p_right + policy.show.worthwhile_gain};
}

double expected_certainty(const Eigen::MatrixXd& squared_distance, const std::vector<double>& probability,
                          std::uint64_t seed) {
  // Places with these distances (classical scaling, Torgerson 1952).
  const Eigen::Index n = squared_distance.rows();
  const Eigen::MatrixXd center =
      Eigen::MatrixXd::Identity(n, n) - Eigen::MatrixXd::Constant(n, n, 1.0 / static_cast<double>(n));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(-0.5 * center * squared_distance * center);
  const Eigen::MatrixXd places =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();  // one per row
  RandomStream random(seed, "next-maneuver");
  double sum = 0.0;
  for (std::size_t d = 0; d < kPolicy.show.outcome_draws; ++d) {
    Eigen::RowVectorXd noise(n);
    for (Eigen::Index i = 0; i < n; ++i) noise[i] = random.normal();
    for (Eigen::Index truth = 0; truth < n; ++truth) {
      const Eigen::RowVectorXd seen = places.row(truth) + noise;
      Eigen::VectorXd log_p(n);
      for (Eigen::Index i = 0; i < n; ++i)
        log_p[i] = std::log(std::max(probability[static_cast<std::size_t>(i)], kPolicy.show.least_probability)) -
                   0.5 * (seen - places.row(i)).squaredNorm();
      const Eigen::VectorXd p = (log_p.array() - log_p.maxCoeff()).exp();
      sum += probability[static_cast<std::size_t>(truth)] * p.maxCoeff() / p.sum();
    }
  }
  return sum / static_cast<double>(kPolicy.show.outcome_draws);
}

std::vector<NextManeuver> next_maneuvers(const Campaign& campaign, const std::vector<const Fitted*>& hypotheses,
                                         std::vector<double> probability, std::size_t jobs, std::uint64_t seed) {
  const double all = std::accumulate(probability.begin(), probability.end(), 0.0);
  for (double& p : probability) p /= all;
  std::vector<Survivor> survivors;
  survivors.reserve(hypotheses.size());
  for (const Fitted* fitted : hypotheses) survivors.push_back(survivor(*fitted, campaign));
  for (Survivor& other : survivors) other.fit.noise = survivors.front().fit.noise;  // of one world
  const Vec2<double> wind = mean_wind(campaign);
  const std::vector<MenuItem> menu = maneuver_menu(campaign.ship, campaign.time_scale());

  std::vector<std::optional<NextManeuver>> tried(menu.size());
  parallel_for(menu.size(), jobs, [&](std::size_t m) {
    if (const auto distance = squared_distances(menu[m], survivors, campaign, wind))
      tried[m] = {menu[m].name, fmt::format("{} --duration-s {:.0f}", menu[m].command, menu[m].each_s),
                  menu[m].each_s * static_cast<double>(menu[m].runs.size()),
                  expected_certainty(*distance, probability, seed)};
  });
  std::vector<NextManeuver> result;
  for (std::optional<NextManeuver>& one : tried)
    if (one) result.push_back(std::move(*one));
  std::stable_sort(result.begin(), result.end(),
                   [](const NextManeuver& a, const NextManeuver& b) { return a.p_right > b.p_right; });
  return result;
}

}  // namespace leeway::gap
