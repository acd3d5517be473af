#include "gap/fit/levels.hpp"

#include <memory>
#include <vector>

#include <catch2/catch.hpp>

#include "gap/simulated_campaign.hpp"

using namespace leeway;

namespace {

// Two recordings in wind, linearized, one with an event, with what was not measured here and there, and with a bias of
// the heading that is free.
std::vector<gap::LinearStretch> windy_stretches(const Ship& ship) {
  const std::vector<Trajectory> recordings = test::recorded(
      {.ship = "esso-osaka-3m", .recordings = 2, .duration_s = 300.0, .wind_mps = 2.0}, read_ship("esso-osaka-3m"));
  gap::Campaign campaign = gap::prepare(ship, recordings, {});
  const auto timing = static_cast<Eigen::Index>(gap::uncertain_parameters(ship).size()) - 1;
  std::vector<gap::LinearStretch> result;
  for (gap::Stretch& stretch : campaign.stretches) {
    for (std::size_t k = 5; k < stretch.measured.size(); k += 7) stretch.measured[k].head<2>().setConstant(kMissing);
    for (std::size_t k = 3; k < stretch.measured.size(); k += 11) stretch.measured[k].setConstant(kMissing);
    stretch.by_faults.first = timing;
    stretch.by_faults.at.assign(stretch.size(), 0.01 * gap::Vec6::Unit(2));
    const auto data = std::make_shared<const gap::Stretch>(stretch);
    result.push_back(gap::linearize(ship, data, gap::measured_path(*data), Eigen::VectorXd::Zero(timing + 2)));
  }
  result[0].event_scale.assign(result[0].path.size(), Vec3<double>::Ones());
  for (std::size_t k = 10; k < 20; ++k) result[0].event_scale[k] = {3.0, 1.0, 2.0};
  result[1].untrained_sd = {2e-3, 1e-3, 5e-4};
  for (gap::LinearStep& step : result[1].steps) step.beyond = 0.3;
  return result;
}

}  // namespace

TEST_CASE("noise levels: the slope of their cost agrees with central differences", "[gap]") {
  Ship ship = read_ship("esso-osaka-3m");
  ship.multiply({{"hull.N_r", 1.2}, {"hull.resistance", 0.8}});  // not the best parameters
  const std::vector<gap::LinearStretch> stretches = windy_stretches(ship);
  const Eigen::Index p = stretches.front().steps.front().G.cols();
  // A column beside the coefficients: a force that acts now and then.
  gap::ExtraColumns extra{1, [](std::size_t) -> gap::MoreColumns {
                            return [](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) {
                              out.setZero();
                              out(4, 0) = k % 13 < 4 ? 1e-3 : 0.0;
                            };
                          }};
  for (const bool one_receiver : {false, true}) {
    CAPTURE(one_receiver);
    gap::Noise noise;
    noise.sigma_w = {5e-4, 8e-4, 3e-4};
    noise.least_sigma_w = {6e-4, 1e-5, 1e-5};  // the first one is at its bound
    noise.tau_s = 9.0;
    noise.least_tau_s = 4.0;
    noise.longest_tau_s = 40.0;
    noise.wind_tau_s = 15.0;
    noise.measurement_sd << 0.03, 0.03, 0.002, 0.01, 0.008, 0.002;
    noise.wind_share = 0.2;
    noise.one_receiver = one_receiver;
    noise.receiver_sd = 0.02;
    noise.receiver_tau_s = 2.5;
    gap::LevelProblem problem{
        stretches,
        0.1 * Eigen::VectorXd::LinSpaced(p + 1, -1.0, 1.0),
        gap::ThetaPrior(Eigen::VectorXd::Constant(p, 0.3)).with(p, Eigen::VectorXd::Constant(1, 10.0)),
        extra,
        noise,
        gap::levels_of(noise).array() + 0.2,
        gap::Levels::Constant(2.0),
        {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}};
    if (one_receiver) problem.free.insert(problem.free.end(), {10, 11});
    const gap::Levels at = gap::levels_of(noise);
    gap::Levels slope;
    const double cost = problem.cost(at, slope);
    CHECK(cost == Approx(problem.costs({at}).front()).epsilon(1e-12));
    for (int i = 0; i < gap::kLevels; ++i) {
      CAPTURE(i);
      if (i >= gap::kReceiverLevel && !one_receiver) {
        CHECK(slope[i] == 0.0);
        continue;
      }
      const double h = 1e-4;
      const std::vector<double> costs = problem.costs({at + h * gap::Levels::Unit(i), at - h * gap::Levels::Unit(i)});
      CHECK(slope[i] == Approx((costs[0] - costs[1]) / (2.0 * h)).epsilon(1e-5).margin(1e-4));
    }
  }
}
