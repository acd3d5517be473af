#include "gap/filter/actuator_errors.hpp"

#include <catch2/catch.hpp>

#include "gap/fit/null_fit.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;

namespace {

constexpr double kNoise = 0.3;  // of usual sensors

std::vector<Trajectory> random_maneuvers(std::size_t count) {
  const Ship ship = read_ship("esso-osaka-3m");
  std::vector<Trajectory> result;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto orders = random_orders(ship, RandomStream(i, "orders"));
    Trajectory run = simulate(SimulatedShip(ship), *orders, {}, {0.1, 1.0, 300.0});
    run.name = run.file = std::to_string(i);
    result.push_back(observed(run, test::usual_noise(kNoise), RandomStream(i, "noise")));
  }
  return result;
}

void round_rudder(Trajectory& recording, double step) {
  for (double& angle : recording[Channel::delta]) angle = std::round(angle / step) * step;
}

// Samples after `first_s` until `end_s` are lost.
void cut_out(Trajectory& recording, double first_s, double end_s) {
  const std::vector<double> t = recording[Channel::t];
  for (std::vector<double>& column : recording.columns) {
    if (column.empty()) continue;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < t.size(); ++i)
      if (t[i] <= first_s || t[i] >= end_s) column[kept++] = column[i];
    column.resize(kept);
  }
}

// Mean square of the innovations of velocities by what the filter expects of it.
double by_expected(gap::Campaign campaign, bool knows_errors) {
  for (gap::Stretch& stretch : campaign.stretches)
    if (!knows_errors) stretch.uncertain.clear(), stretch.actuator_errors.clear();
  gap::Noise noise;
  noise.sigma_w = {1e-6, 1e-6, 1e-7};
  noise.tau_s = 10.0;
  noise.wind_tau_s = 15.0;
  const ObservationNoise sensors = test::usual_noise(kNoise);
  noise.measurement_sd << sensors.x0, sensors.y0, sensors.psi, sensors.u, sensors.vm, sensors.r;
  double squares = 0.0, count = 0.0;
  for (const gap::Stretch& stretch : campaign.stretches) {
    const auto data = std::make_shared<const gap::Stretch>(stretch);
    const auto n = static_cast<Eigen::Index>(gap::uncertain_parameters(campaign.ship).size());
    const Eigen::VectorXd theta = Eigen::VectorXd::Zero(n);
    const gap::LinearStretch begun = gap::linearize(campaign.ship, data, gap::measured_path(*data), theta);
    const gap::LinearStretch linear = gap::linearize_filtered(campaign.ship, begun, data, noise, {}, theta);
    for (const gap::Vec6& z : gap::smooth(linear, noise, theta).innovations)
      for (const double one : z)
        if (std::isfinite(one)) squares += one * one, count += 1.0;
  }
  return squares / count;
}

}  // namespace

TEST_CASE("actuator errors: a rudder in whole degrees errs by their rounding, for as long as it shows one", "[gap]") {
  std::vector<Trajectory> recordings = random_maneuvers(3);
  const Ship ship = read_ship("esso-osaka-3m");
  CHECK(gap::prepare(ship, recordings, {}).stretches.front().uncertain.empty());
  for (Trajectory& recording : recordings) round_rudder(recording, 1.0 * kDegree);
  const gap::Campaign campaign = gap::prepare(ship, recordings, {});
  const gap::Stretch& stretch = campaign.stretches.front();
  REQUIRE(stretch.uncertain == std::vector{Channel::delta});
  REQUIRE(stretch.actuator_errors.size() + 1 == stretch.size());
  const RecordedInputs& inputs = campaign.recorded_inputs.front();
  std::size_t going_on = 0;
  for (std::size_t k = 0; k + 1 < stretch.actuator_errors.size(); ++k) {
    CHECK(stretch.actuator_errors[k].sd[0] == Approx(1.0 * kDegree / std::sqrt(12.0)));
    const double from = inputs.at(stretch.t_s[k + 1]).actuators[Channel::delta],
                 to = inputs.at(stretch.t_s[k + 2]).actuators[Channel::delta];
    if (stretch.actuator_errors[k].goes_on[0]) {
      CHECK(std::abs(to - from) < 1.0 * kDegree);
      ++going_on;
    }
  }
  CHECK(going_on > stretch.size() / 2);
  // Orders in steps of 5 deg are no rounding.
  for (Trajectory& recording : recordings) round_rudder(recording, 5.0 * kDegree);
  CHECK(gap::prepare(ship, recordings, {}).stretches.front().uncertain.empty());
}

TEST_CASE("actuator errors: with them the filter expects what it is surprised by without", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  std::vector<Trajectory> rounded = random_maneuvers(3), lossy = rounded;
  CHECK(by_expected(gap::prepare(ship, rounded, {}), true) == Approx(1.0).margin(0.15));
  for (Trajectory& recording : rounded) round_rudder(recording, 1.0 * kDegree);
  CHECK(by_expected(gap::prepare(ship, rounded, {}), true) == Approx(1.0).margin(0.15));
  CHECK(by_expected(gap::prepare(ship, rounded, {}), false) > 1.5);
  for (Trajectory& recording : lossy)
    for (int i = 1; i < 12; ++i) cut_out(recording, 25.0 * i, 25.0 * i + 3.0);
  const double with = by_expected(gap::prepare(ship, lossy, {}), true);
  CHECK(with == Approx(1.0).margin(0.3));
  CHECK(by_expected(gap::prepare(ship, lossy, {}), false) > 1.1 * with);
}

TEST_CASE("actuator errors: in a hole a rudder that is where it was has hardly been elsewhere", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  std::vector<Trajectory> recordings = random_maneuvers(3);
  const std::vector<double>& t = recordings.front()[Channel::t];
  const std::vector<double>& delta = recordings.front()[Channel::delta];
  // Two samples lost where it stays, and where it moves.
  double stays_s = 0.0, moves_s = 0.0;
  for (std::size_t k = 30; k + 3 < t.size(); ++k) {
    if (stays_s == 0.0 && delta[k] == delta[k + 3]) stays_s = t[k];
    if (moves_s == 0.0 && std::abs(delta[k] - delta[k + 3]) > 10.0 * kDegree) moves_s = t[k];
  }
  REQUIRE(stays_s * moves_s > 0.0);
  const auto sd_in_hole = [&](double from_s) {
    std::vector<Trajectory> lossy = recordings;
    cut_out(lossy.front(), from_s, from_s + 3.0);
    const gap::Campaign campaign = gap::prepare(ship, lossy, {});
    const gap::Stretch& stretch = campaign.stretches.front();
    double most = 0.0;
    for (std::size_t k = 0; k < stretch.actuator_errors.size(); ++k) {
      const double sd = stretch.actuator_errors[k].sd[0];
      if (stretch.t_s[k] >= from_s + 3.0 || stretch.t_s[k + 1] <= from_s) CHECK(sd == 0.0);
      most = std::max(most, sd);
    }
    return most / kDegree;
  };
  CHECK(sd_in_hole(moves_s) > 2.0);
  CHECK(sd_in_hole(stays_s) < 0.5 * sd_in_hole(moves_s));
}

TEST_CASE("actuator errors: a stretch ends where nobody knows what the rudder did", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  std::vector<Trajectory> recordings = random_maneuvers(3);
  CHECK(gap::prepare(ship, recordings, {}).stretches.size() == 3);
  for (Trajectory& recording : recordings) cut_out(recording, 100.0, 120.0);
  const gap::Campaign campaign = gap::prepare(ship, recordings, {});
  CHECK(campaign.stretches.size() == 6);
  CHECK(by_expected(campaign, true) == Approx(1.0).margin(0.1));
  // Those that are kept in their places are known in such a hole.
  for (Trajectory& recording : recordings)
    for (const Channel channel : {Channel::delta, Channel::n_p})
      std::ranges::fill(recording[channel], recording[channel].front());
  CHECK(gap::prepare(ship, recordings, {}).stretches.size() == 3);
}
