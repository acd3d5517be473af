#include "gap/locate/patterns.hpp"

#include <memory>

#include <catch2/catch.hpp>

#include "gap/simulated_campaign.hpp"

using namespace leeway;

TEST_CASE("patterns: how she moves in a step does not know what drove her away in it", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const test::SimulatedCampaign of{.ship = "esso-osaka-3m", .recordings = 1, .duration_s = 60.0, .sample_s = 3.0};
  const gap::Campaign campaign = gap::prepare(ship, test::recorded(of, ship), {});
  const auto data = std::make_shared<const gap::Stretch>(campaign.stretches.front());
  const Eigen::VectorXd theta =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(gap::uncertain_parameters(ship).size()));
  const std::vector<gap::StateVector> path = gap::measured_path(*data);
  constexpr std::size_t kStep = 10;
  std::vector<gap::StateVector> driven = path;
  driven[kStep + 1][5] += 0.02;  // the yaw rate at the end of the step [rad/s]
  const gap::LinearStretch one = gap::linearize(ship, data, path, theta),
                           other = gap::linearize(ship, data, driven, theta);
  const gap::Moment before = gap::moment_of(one, kStep), after = gap::moment_of(other, kStep);
  CHECK(after.r == Approx(before.r));
  CHECK(after.v == Approx(before.v));
  CHECK(gap::moment_of(other, kStep + 1).r > gap::moment_of(one, kStep + 1).r + 0.005);
}
