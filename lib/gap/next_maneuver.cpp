#include "gap/next_maneuver.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "core/units.hpp"
#include "dynamics/phased_maneuvers.hpp"

namespace leeway::gap {
namespace {

constexpr std::size_t kOutcomeDraws = 4000;
constexpr double kApart = 1e4;  // squared distance of what nothing could confuse

// One run of a maneuver: from a ship under way, turned to a heading.
struct ManeuverRun {
  double heading_rad = 0.0;
  std::function<std::unique_ptr<Maneuver>(const SimulatedShip&)> make;
};
struct MenuItem {
  std::string name, command;
  double each_s = 0.0;
  std::vector<ManeuverRun> runs;
};

std::vector<MenuItem> menu_for(const Ship& ship, double time_scale) {
  const double largest = 35.0 * kDegree;
  const auto turn = [&](double sign) {
    return ManeuverRun{0.0, [=](const SimulatedShip& s) { return turning(s.ship, sign * largest); }};
  };
  const auto zigzag_of = [](double deg) {
    return ManeuverRun{0.0, [=](const SimulatedShip& s) { return zigzag(s.ship, deg * kDegree, deg * kDegree); }};
  };
  const auto straight_at = [](double heading) {
    return ManeuverRun{heading, [](const SimulatedShip& s) { return straight(s.ship, course_keeper(s)); }};
  };
  const double s = time_scale;
  std::vector<MenuItem> menu{
      {"a straight run and its reciprocal", "straight", 100.0 * s, {straight_at(0.0), straight_at(kPi)}},
      {"turning circles, 35 deg to both sides",
       "turning --rudder-deg 35 (and -35)",
       120.0 * s,
       {turn(1.0), turn(-1.0)}},
      {"a zigzag 10/10", "zigzag --rudder-deg 10 --heading-deg 10", 150.0 * s, {zigzag_of(10.0)}},
      {"a zigzag 20/20", "zigzag --rudder-deg 20 --heading-deg 20", 150.0 * s, {zigzag_of(20.0)}},
      {"a coast-down with stopped propeller",
       "coast-down",
       120.0 * s,
       {{0.0, [](const SimulatedShip& at) { return coast_down(at); }}}},
      {"a crash stop", "crash-stop", 120.0 * s, {{0.0, [](const SimulatedShip& at) { return crash_stop(at); }}}},
      {"a pull-out",
       "pull-out",
       200.0 * s,
       {{0.0, [=](const SimulatedShip& at) { return pull_out(at, 20.0 * kDegree); }}}},
      {"random orders to all actuators",
       "random",
       200.0 * s,
       {{0.0, [](const SimulatedShip& at) { return random_orders(at.ship, RandomStream(1, "next-maneuver")); }}}},
  };
  if (std::any_of(ship.actuators.begin(), ship.actuators.end(),
                  [](const Actuator& a) { return a.channel == Channel::n_bt || a.channel == Channel::n_st; }))
    menu.push_back({"thruster pulses", "thruster-pulses", 200.0 * s, {{0.0, [](const SimulatedShip& at) {
                                                                         return thruster_pulses(
                                                                             at, thruster_pulses_for(at.ship));
                                                                       }}}});
  return menu;
}

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
    grid.dt_s = step_s / std::ceil(step_s / (0.1 * std::sqrt(ship.particulars.L_pp / 3.0)));
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
double misfit(const Campaign& recorded, const Survivor& other) {
  Campaign campaign = recorded;
  const FittedNull there = follow(campaign, other.fit, other.hypothesis, 1);
  const Evidence& e = there.total;
  if (!std::isfinite(e.log_likelihood)) return kApart;
  return -2.0 * e.log_likelihood - e.b.dot((e.F + other.precision).llt().solve(e.b));
}

}  // namespace

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
  for (std::size_t d = 0; d < kOutcomeDraws; ++d) {
    Eigen::RowVectorXd noise(n);
    for (Eigen::Index i = 0; i < n; ++i) noise[i] = random.normal();
    for (Eigen::Index truth = 0; truth < n; ++truth) {
      const Eigen::RowVectorXd seen = places.row(truth) + noise;
      Eigen::VectorXd log_p(n);
      for (Eigen::Index i = 0; i < n; ++i)
        log_p[i] = std::log(std::max(probability[static_cast<std::size_t>(i)], 1e-300)) -
                   0.5 * (seen - places.row(i)).squaredNorm();
      const Eigen::VectorXd p = (log_p.array() - log_p.maxCoeff()).exp();
      sum += probability[static_cast<std::size_t>(truth)] * p.maxCoeff() / p.sum();
    }
  }
  return sum / static_cast<double>(kOutcomeDraws);
}

std::vector<NextManeuver> next_maneuvers(const Campaign& campaign, const std::vector<const Fitted*>& hypotheses,
                                         std::vector<double> probability, std::size_t jobs, std::uint64_t seed) {
  const double all = std::accumulate(probability.begin(), probability.end(), 0.0);
  for (double& p : probability) p /= all;
  std::vector<Survivor> survivors;
  for (const Fitted* fitted : hypotheses) survivors.push_back(survivor(*fitted, campaign));
  for (Survivor& other : survivors) other.fit.noise = survivors.front().fit.noise;  // of one world
  const Vec2<double> wind = mean_wind(campaign);
  const std::vector<MenuItem> menu = menu_for(campaign.ship, campaign.time_scale());

  const auto n = static_cast<Eigen::Index>(survivors.size());
  std::vector<std::optional<NextManeuver>> told(menu.size());
  parallel_for(menu.size(), jobs, [&](std::size_t m) {
    Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      std::optional<Campaign> recorded;
      try {
        recorded =
            prepare(campaign.ship,
                    simulated(menu[m], survivors[static_cast<std::size_t>(i)], campaign.ship, wind, campaign.step_s),
                    {campaign.step_s, 0.0});
      } catch (const UsageError&) {  // the ship cannot do this
        return;
      } catch (const NumericalError&) {
        return;
      } catch (const InputError&) {  // nothing moves
        return;
      }
      const double right = misfit(*recorded, survivors[static_cast<std::size_t>(i)]);
      for (Eigen::Index j = 0; j < n; ++j)
        if (j != i)
          apart(i, j) = std::clamp(misfit(*recorded, survivors[static_cast<std::size_t>(j)]) - right, 0.0, kApart);
    }
    const Eigen::MatrixXd both = 0.5 * (apart + apart.transpose());
    told[m] = {menu[m].name, menu[m].command, menu[m].each_s * static_cast<double>(menu[m].runs.size()),
               expected_certainty(both, probability, seed)};
  });
  std::vector<NextManeuver> result;
  for (std::optional<NextManeuver>& one : told)
    if (one) result.push_back(std::move(*one));
  std::stable_sort(result.begin(), result.end(),
                   [](const NextManeuver& a, const NextManeuver& b) { return a.p_right > b.p_right; });
  return result;
}

}  // namespace leeway::gap
