#include "control/pd_sweep.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "dynamics/maneuvers.hpp"
#include "ensemble/synthetic.hpp"

using namespace leeway;
using namespace leeway::control;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

// Untrained members: what the sweep does with them does not depend on what they learned.
ensemble::Ensemble small_ensemble() {
  ensemble::TrainingConfig config;
  config.steps = 20;
  config.initial_state_steps = 5;
  config.hidden_layers = 1;
  config.hidden_units = 6;
  config.members = 3;
  const ensemble::TrainingData data = ensemble::prepare_training_data({test::synthetic_recording(1, 60)}, config);
  std::vector<ensemble::Member> members;
  for (int m = 0; m < 3; ++m)
    members.push_back(ensemble::initial_training_state(data, 1, m, nn::kernels("portable")).member);
  return {ensemble::make_header(data, 1, {}), members, nn::kernels("portable")};
}

const SweepResult& sweep_one(const PdGains& gains) {
  static const ensemble::Ensemble ensemble = small_ensemble();
  static std::vector<SweepResult> result;
  result = pd_sweep(read_ship("vectwin-3m"), ensemble, {gains}, {}, 50, 1, 2, true);
  return result.front();
}

}  // namespace

TEST_CASE("gain sweep: the command is in degrees of rudder per radian and turns towards the set heading", "[control]") {
  const PdGains gains{60.0, 30.0};
  // 0.5 rad to port of the set heading, turning to starboard at 0.1 rad/s: 60 * 0.5 - 30 * 0.1 = 27 deg to starboard.
  CHECK_THAT(rad_to_deg(gains.command(-0.5, 0.1)), WithinRel(27.0, 1e-12));
}

TEST_CASE("gain sweep: the true ship's score is that of a run stepped by hand", "[control]") {
  const SweepResult& result = sweep_one({40.0, 25.0});
  SimulatedShip ship(read_ship("vectwin-3m"));
  ship.state.nu = {0.5, 0.0, 0.0};
  double integral = 0.0, before = 0.0;
  for (int k = 0; k <= 1000; ++k) {
    const double psi = ship.state.eta(2), r = ship.state.nu(2);
    const double now = std::abs(psi - kPi / 2.0) + std::abs(r);
    if (k > 0) integral += 0.05 * (before + now);
    before = now;
    Actuators<double> command = ship.ship.initial_actuators();
    command[Channel::delta_p] = command[Channel::delta_s] = -(40.0 * (psi - kPi / 2.0) + 25.0 * r) * kPi / 180.0;
    command[Channel::n_bt] = 0.0;
    ship.step(command, Vec2<double>::Zero(), 0.1);
  }
  CHECK_THAT(result.score_true, WithinRel(integral, 1e-9));
  CHECK(integral < 40.0);  // the controller works: without turning the score would be 157
}

TEST_CASE("gain sweep: without gains the heading stays where the ship drifts, and the score says so", "[control]") {
  const SweepResult& result = sweep_one({0.0, 0.0});
  for (const double rudder : result.run_true.rudder) CHECK(rudder == 0.0);
  const double mean_error = std::abs(result.run_true.eta.front()(2) - kPi / 2.0);
  CHECK_THAT(mean_error, WithinRel(kPi / 2.0, 1e-12));
  CHECK(result.run_true.eta.size() == 101);
}

TEST_CASE("gain sweep: rudders keep to their own ranges and rates", "[control]") {
  const SweepResult& result = sweep_one({500.0, 0.0});
  double largest_port = -1e9, largest_starboard = -1e9;
  for (std::size_t i = 0; i + 1 < result.run_true.rudder.size(); i += 2) {
    largest_port = std::max(largest_port, result.run_true.rudder[i]);
    largest_starboard = std::max(largest_starboard, result.run_true.rudder[i + 1]);
  }
  CHECK_THAT(rad_to_deg(largest_port), WithinAbs(35.0, 1e-6));
  CHECK_THAT(rad_to_deg(largest_starboard), WithinAbs(105.0, 1e-6));
  CHECK_THAT(rad_to_deg(result.run_true.rudder[2]), WithinAbs(20.0, 1e-6));  // 20 deg/s for one second
}

TEST_CASE("gain sweep: mean, worst and best are those of the particles", "[control]") {
  const SweepResult& result = sweep_one({40.0, 25.0});
  REQUIRE(result.score_members.size() == 3);
  CHECK(result.score_worst == *std::max_element(result.score_members.begin(), result.score_members.end()));
  CHECK(result.score_best == *std::min_element(result.score_members.begin(), result.score_members.end()));
  CHECK(result.score_mean < result.score_worst);
  CHECK(result.score_mean > result.score_best);
}

TEST_CASE("gain sweep: gains beside each other and any number of jobs give the bits of each gain alone", "[control]") {
  std::vector<PdGains> gains;
  for (int i = 0; i < 7; ++i) gains.push_back({20.0 + 7.0 * i, 15.0 + 3.0 * i});
  const ensemble::Ensemble ensemble = small_ensemble();
  const Ship ship = read_ship("vectwin-3m");
  HeadingTask task;
  task.duration_s = 20.0;
  const std::vector<SweepResult> one = pd_sweep(ship, ensemble, gains, task, 50, 1, 1, false);
  const std::vector<SweepResult> two = pd_sweep(ship, ensemble, gains, task, 50, 1, 2, false);
  for (std::size_t i = 0; i < gains.size(); ++i) {
    CHECK(one[i].score_true == two[i].score_true);
    CHECK(one[i].score_members == two[i].score_members);
    CHECK(one[i].score_members == pd_sweep(ship, ensemble, {gains[i]}, task, 50, 1, 1, false).front().score_members);
  }
}

TEST_CASE("gain sweep: ranges include both ends", "[control]") {
  CHECK(parse_gain_range("--kp", "5:100:5").size() == 20);
  CHECK(parse_gain_range("--kp", "0.1:0.3:0.1").size() == 3);
  CHECK(parse_gain_range("--kp", "60") == std::vector<double>{60.0});
  CHECK(parse_gain_range("--kp", "20,40.5") == std::vector<double>{20.0, 40.5});
  for (const char* wrong : {"", "a", "5:1:1", "5:10", "5:10:0", "1,,2", "nan"})
    CHECK_THROWS_WITH(parse_gain_range("--kp", wrong), Contains("--kp") && Contains("LOW:HIGH:STEP"));
}
