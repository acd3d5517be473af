#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "dynamics/berthing.hpp"
#include "dynamics/dataset.hpp"
#include "dynamics/maneuvers.hpp"
#include "dynamics/observation_noise.hpp"

namespace leeway::test {

/// A simulated campaign: zigzags, turns, random maneuvers and, where the ship can, berthings in turn.
struct SimulatedCampaign {
  std::string ship = "vectwin-3m";
  std::uint64_t seed = 1;
  std::size_t recordings = 8;
  double duration_s = 240.0, sample_s = 1.0;
  double wind_mps = 0.5;
};

/// The noise-free truth, sampled at 0.1 s: what a sensor with a latency reads lies between the samples of a recording.
inline std::vector<Trajectory> fine_truth(const SimulatedCampaign& campaign, const Ship& ship) {
  std::vector<Trajectory> result;
  for (std::size_t i = 0; i < campaign.recordings; ++i) {
    RandomStream draw(campaign.seed, "campaign", i);
    const double angle = (draw.uniform() < 0.5 ? -1.0 : 1.0) * draw.uniform(10.0, 30.0) * kDegree;
    const double wind_dir = draw.uniform(0.0, 2.0 * kPi), course = draw.uniform(0.0, 2.0 * kPi);
    SimulatedShip start(ship);
    std::unique_ptr<Maneuver> maneuver;
    switch (i % (ship.has_twin_rudders() ? 4 : 3)) {
      case 0:
        maneuver = zigzag(ship, angle, std::min(std::abs(angle), 20.0 * kDegree));
        break;
      case 1:
        maneuver = random_orders(ship, RandomStream(campaign.seed, "campaign orders", i));
        break;
      case 2:
        maneuver = turning(ship, angle);
        break;
      default: {
        const BerthingPlan plan = draw_berthing(ship, RandomStream(campaign.seed, "campaign berthing", i));
        start = ship_at_start(ship, plan.steering);
        maneuver = berthing(ship, plan, RandomStream(campaign.seed, "campaign pilot", i));
      }
    }
    start.state.eta(2) += course;
    WindProcess wind;
    if (campaign.wind_mps > 0.0)
      wind = WindProcess::stochastic(campaign.wind_mps, wind_dir, RandomStream(campaign.seed, "campaign wind", i));
    Trajectory run = simulate(start, *maneuver, wind, {0.1, 0.1, campaign.duration_s});
    run.name = run.file = "run" + std::to_string(i);
    result.push_back(std::move(run));
  }
  return result;
}

/// A channel of an equidistant recording at another time: a cubic through the four samples around it. Beyond the ends
/// it goes on straight, as the ship roughly did.
inline double at_time(const Trajectory& recording, Channel channel, double t_s) {
  const std::vector<double>&t = recording[Channel::t], &x = recording[channel];
  const double dt = t[1] - t[0], last = static_cast<double>(t.size() - 3);
  const double place = (t_s - t[0]) / dt;
  if (place < 0.0) return x[0] + place * (x[1] - x[0]);
  const double k = std::clamp(std::floor(place), 1.0, last), b = place - k;
  const double* at = x.data() + static_cast<std::size_t>(k);
  return at[-1] * -b * (b - 1.0) * (b - 2.0) / 6.0 + at[0] * (b + 1.0) * (b - 1.0) * (b - 2.0) / 2.0 +
         at[1] * -(b + 1.0) * b * (b - 2.0) / 2.0 + at[2] * (b + 1.0) * b * (b - 1.0) / 6.0;
}

/// What sensors with faults make of the truth. SI and radians.
struct Injected {
  double heading_bias = 0.0, lever_x = 0.0, lever_y = 0.0, log_scale = 0.0, log_bias_u = 0.0, log_bias_v = 0.0;
  double current_x = 0.0, current_y = 0.0, rate_bias = 0.0, rate_scale = 0.0, filter_s = 0.0;
  bool filters_heading = false;  // as well, before its latency
  double velocity_latency_s = 0.0, heading_latency_s = 0.0, rate_latency_s = 0.0, position_latency_s = 0.0;
};

inline Trajectory with_fault(const Trajectory& truth, const Injected& fault) {
  Trajectory seen = truth;
  std::vector<double> psi = truth[Channel::psi];
  if (fault.filters_heading)
    for (std::size_t k = 1; k < psi.size(); ++k) {
      const double share = 1.0 - std::exp(-(truth[Channel::t][k] - truth[Channel::t][k - 1]) / fault.filter_s);
      psi[k] = psi[k - 1] + share * (0.5 * (truth[Channel::psi][k - 1] + truth[Channel::psi][k]) - psi[k - 1]);
    }
  Trajectory lagging;
  lagging[Channel::t] = truth[Channel::t];
  lagging[Channel::psi] = psi;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double t = truth[Channel::t][k];
    const auto psi_at = [&](double then) { return at_time(truth, Channel::psi, then); };
    const double tp = t - fault.position_latency_s, tv = t - fault.velocity_latency_s;
    const double c = std::cos(psi_at(tp)), s = std::sin(psi_at(tp));
    seen[Channel::x0][k] = at_time(truth, Channel::x0, tp) + c * fault.lever_x - s * fault.lever_y;
    seen[Channel::y0][k] = at_time(truth, Channel::y0, tp) + s * fault.lever_x + c * fault.lever_y;
    seen[Channel::psi][k] = at_time(lagging, Channel::psi, t - fault.heading_latency_s) + fault.heading_bias;
    const double cv = std::cos(psi_at(tv)), sv = std::sin(psi_at(tv));
    seen[Channel::u][k] =
        (1.0 + fault.log_scale) * (at_time(truth, Channel::u, tv) - cv * fault.current_x - sv * fault.current_y) +
        fault.log_bias_u;
    seen[Channel::vm][k] =
        at_time(truth, Channel::vm, tv) + sv * fault.current_x - cv * fault.current_y + fault.log_bias_v;
    seen[Channel::r][k] =
        (1.0 + fault.rate_scale) * at_time(truth, Channel::r, t - fault.rate_latency_s) + fault.rate_bias;
  }
  if (fault.filter_s > 0.0)
    for (const Channel channel : {Channel::u, Channel::vm, Channel::r}) {
      const std::vector<double> x = seen[channel];
      for (std::size_t k = 1; k < x.size(); ++k) {
        const double share = 1.0 - std::exp(-(truth[Channel::t][k] - truth[Channel::t][k - 1]) / fault.filter_s);
        seen[channel][k] = seen[channel][k - 1] + share * (0.5 * (x[k - 1] + x[k]) - seen[channel][k - 1]);
      }
    }
  return seen;
}

/// Every n-th sample.
inline Trajectory thinned(const Trajectory& recording, std::size_t n) {
  Trajectory result = recording;
  for (std::vector<double>& column : result.columns) {
    std::vector<double> kept;
    for (std::size_t k = 0; k < column.size(); k += n) kept.push_back(column[k]);
    column = std::move(kept);
  }
  return result;
}

/// The noise of the ensemble paper's model scale, and of a good pose.
inline ObservationNoise usual_noise(double factor = 1.0) {
  return {0.03 * factor, 0.03 * factor, 0.1 * kDegree * factor, 0.01 * factor, 0.01 * factor, 0.1 * kDegree * factor};
}

/// The recordings of a campaign by sensors with a fault.
inline std::vector<Trajectory> recorded(const SimulatedCampaign& campaign, const Ship& ship, const Injected& fault = {},
                                        double noise_factor = 1.0) {
  std::vector<Trajectory> result;
  const std::vector<Trajectory> truth = fine_truth(campaign, ship);
  for (std::size_t i = 0; i < truth.size(); ++i)
    result.push_back(
        observed(thinned(with_fault(truth[i], fault), static_cast<std::size_t>(std::lround(campaign.sample_s / 0.1))),
                 usual_noise(noise_factor), RandomStream(campaign.seed, "campaign noise", i)));
  return result;
}

}  // namespace leeway::test
