#include "gap/show/beyond_recorded.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/units.hpp"
#include "dynamics/indices.hpp"
#include "dynamics/maneuvers.hpp"
#include "effects/registry.hpp"
#include "gap/policy/policy.hpp"
#include "gap/show/left_out.hpp"

namespace leeway::gap {
namespace {

double largest_recorded_rudder(const Campaign& campaign) {
  double largest = 0.0;
  for (const Stretch& stretch : campaign.stretches)
    for (const auto& steps : stretch.inputs)
      for (const Actuator& actuator : campaign.ship.actuators)
        if (actuator.is_rudder())
          largest = std::max(largest, std::abs(steps.front().start.actuators[actuator.channel]));
  return largest;
}

// By L_pp; NaN where the ship does not come round.
double tactical_diameter(const Ship& ship, double rudder, double time_scale) {
  try {
    const double step_s = kPolicy.show.longest_step_s * time_scale;
    const TimeGrid grid{step_s, step_s, step_s * std::ceil(kPolicy.show.turning_s * time_scale / step_s)};
    const auto maneuver = turning(ship, rudder);
    const Trajectory run = simulate(SimulatedShip(ship), *maneuver, WindProcess(), grid);
    const io::Json indices = turning_indices(Track(run), rudder, ship.particulars.L_pp);
    const io::Json& value = indices.at("tactical_diameter_m");
    return value.is_number() ? std::abs(value.get<double>()) / ship.particulars.L_pp : kMissing;
  } catch (const NumericalError&) {
    return kMissing;
  }
}

// An effect's formula errs beside what recordings leave open of its strength.
Eigen::VectorXd with_errors_of_formulas(const Hypothesis& hypothesis, Eigen::Index coefficients, RandomStream& random,
                                        Eigen::VectorXd theta) {
  for (const EffectSpan& span : spans_of(hypothesis)) {
    if (span.effects > 1) continue;  // another one in each recording: none of them stays with the ship
    auto own = theta.segment(coefficients + span.first, span.count);
    const Eigen::VectorXd sd = hypothesis.effects[span.effect].sd_of_formula(own);
    for (Eigen::Index i = 0; i < span.count; ++i) own[i] += random.normal() * sd[i];
  }
  return theta;
}

bool is_of_surroundings(const EffectEntry& entry) { return effect_named(entry.type).info.is_of_surroundings; }

}  // namespace

std::optional<BeyondRecorded> turning_beyond_recorded(const Answered& of, const Explanation& explanation) {
  if (explanation.coefficient_factors.empty() && std::ranges::all_of(explanation.effects, is_of_surroundings))
    return std::nullopt;  // the ship is as its file says
  const Ship& ship = of.campaign.ship;
  double limit = 0.0;
  for (const Actuator& actuator : ship.actuators)
    if (actuator.is_rudder()) limit = std::max(limit, std::min(-actuator.min, actuator.max));
  const double rudder = std::min(limit, kPolicy.show.turning_rudder_deg * kDegree),
               recorded = largest_recorded_rudder(of.campaign);
  if (!(recorded < kPolicy.show.as_much_rudder * rudder)) return std::nullopt;

  const FittedNull& fit = of.answer.fit;
  const Eigen::Index n = fit.theta.size(), coefficients = n - 1 - fit.effects;
  const Eigen::MatrixXd M = fit.total.F + fit.prior.precision();
  const Eigen::LLT<Eigen::MatrixXd> llt(M);
  std::vector<double> found(kPolicy.show.turning_draws);
  parallel_for(found.size(), of.options.locate.jobs, [&](std::size_t d) {
    RandomStream random(of.options.locate.seed, "turning-beyond-recorded", d);
    Eigen::VectorXd normal(n);
    for (double& one : normal) one = random.normal();
    const Eigen::VectorXd drawn =
        with_errors_of_formulas(of.answer.hypothesis, coefficients, random,
                                fit.theta + std::sqrt(of.answer.kappa) * Eigen::VectorXd(llt.matrixU().solve(normal)));
    const Eigen::VectorXd theta = d == 0 ? fit.theta : drawn;
    Ship one = of.answer.hypothesis.applied_to(ship, theta.segment(coefficients, fit.effects));
    std::erase_if(one.effects, is_of_surroundings);  // in still water and calm air
    // Coefficients that ship.json leaves as they are have errors all the same.
    one.multiply(coefficient_changes(fit, explanation.coefficient_factors.empty() ? theta - fit.theta : theta));
    found[d] = tactical_diameter(one, rudder, of.campaign.time_scale());
  });
  const double best = found.front();
  std::erase_if(found, [](double d) { return std::isnan(d); });
  if (std::isnan(best) || found.size() < kPolicy.show.turning_draws / 2) return std::nullopt;
  std::sort(found.begin(), found.end());
  const auto quantile = [&](double p) {
    return found[static_cast<std::size_t>(std::lround(p * static_cast<double>(found.size() - 1)))];
  };
  return BeyondRecorded{recorded / kDegree, rudder / kDegree, best, quantile(kPolicy.show.tail95),
                        quantile(1.0 - kPolicy.show.tail95)};
}

}  // namespace leeway::gap
