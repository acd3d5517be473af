#include "dynamics/replay.hpp"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/maneuvers.hpp"
#include "dynamics/observation_noise.hpp"
#include "forces/registry.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;

namespace {

Trajectory recorded(const Ship& ship, double sample_s) {
  const auto maneuver = random_orders(ship, {5, "random orders"});
  Trajectory t = simulate(SimulatedShip(ship), *maneuver, wind_from_vector(1.1, 0.7), {0.1, sample_s, 120.0});
  t.name = "recorded";
  t.file = "recorded.csv";
  return t;
}

}  // namespace

TEST_CASE("replay: a simulated recording is followed, with its true or its apparent wind", "[dynamics]") {
  const Ship ship = read_ship("vectwin-3m");
  for (const bool apparent_only : {false, true}) {
    Trajectory recording = recorded(ship, 0.1);
    if (apparent_only) {
      recording[Channel::wind_speed].clear();
      recording[Channel::wind_dir].clear();
    }
    const RecordedInputs inputs(recording, ship, InputInterpolation::linear);
    CHECK(inputs.notices().empty());
    const Trajectory result = replay(ship, recording, inputs, {0.1, 0.1, 0.1});
    REQUIRE(result.size() == recording.size());
    // Actuators bend within a step, which a line between samples does not: a difference of second order in the step.
    for (std::size_t i = 0; i < result.size(); ++i) {
      CHECK_THAT(result[Channel::u][i], WithinAbs(recording[Channel::u][i], 2e-4));
      CHECK_THAT(result[Channel::vm][i], WithinAbs(recording[Channel::vm][i], 2e-4));
      CHECK_THAT(result[Channel::r][i], WithinAbs(recording[Channel::r][i], 2e-4));
    }
  }
}

TEST_CASE("replay: inputs are linear or held between samples, and held over missing ones", "[dynamics]") {
  const Ship ship = read_ship("esso-osaka-3m");
  Trajectory recording;
  recording.file = "gap.csv";
  recording[Channel::t] = {10.0, 11.0, 12.0, 13.0};
  recording[Channel::u] = recording[Channel::vm] = recording[Channel::r] = {0.1, 0.1, 0.1, 0.1};
  recording[Channel::delta] = {0.2, kMissing, kMissing, 0.4};
  recording[Channel::n_p] = {8.0, 10.0, 12.0, 12.0};
  const RecordedInputs linear(recording, ship, InputInterpolation::linear);
  CHECK_THAT(linear.at(10.5).actuators[Channel::n_p], WithinAbs(9.0, 1e-14));
  CHECK(linear.at(11.7).actuators[Channel::delta] == 0.2);
  CHECK_THAT(linear.at(12.5).actuators[Channel::delta], WithinAbs(0.3, 1e-14));
  CHECK(linear.at(13.0).actuators[Channel::delta] == 0.4);
  const RecordedInputs held(recording, ship, InputInterpolation::hold);
  const StepInputs<double> step = held.step(10.5, 0.5);
  CHECK(step.start.actuators[Channel::n_p] == 8.0);
  CHECK(step.end.actuators[Channel::n_p] == 8.0);  // the new value belongs to the next step
  CHECK(held.step(11.0, 0.5).start.actuators[Channel::n_p] == 10.0);
  REQUIRE(linear.notices().size() == 1);  // no wind: calm is assumed, and said
}

TEST_CASE("replay: an actuator moves at its own rate, next to the interval in which it moves on", "[dynamics]") {
  const Ship ship = read_ship("esso-osaka-3m");
  double rate = 0.0;
  for (const Actuator& actuator : ship.actuators)
    if (actuator.channel == Channel::delta) rate = actuator.rate;
  Trajectory recording;
  recording.file = "steps.csv";
  recording[Channel::t] = {0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0};
  recording[Channel::u] = recording[Channel::vm] = recording[Channel::r] = std::vector<double>(9, 0.1);
  recording[Channel::n_p] = std::vector<double>(9, 10.0);
  // From 0.6 s on at full rate until 2.2 s; half of a second's way between 4 and 5 s; a little from 6 to 8 s, as noise
  // does.
  const double a = 0.4 * rate, b = 1.4 * rate, c = 1.6 * rate, d = 1.1 * rate;
  recording[Channel::delta] = {0.0, a, b, c, c, d, d, d - 0.05 * rate, d - 0.1 * rate};
  const RecordedInputs inputs(recording, ship, InputInterpolation::at_actuator_rate);
  const auto at = [&](double t_s) { return inputs.at(t_s).actuators[Channel::delta]; };
  for (const double t_s : {0.3, 0.6, 0.8, 1.0, 1.5, 2.0, 2.1, 2.2, 2.9}) {
    CAPTURE(t_s);
    CHECK_THAT(at(t_s), WithinAbs(rate * std::clamp(t_s - 0.6, 0.0, 1.6), 1e-12));
  }
  for (const double t_s : {3.5, 4.0, 4.2, 4.5, 4.9}) {
    CAPTURE(t_s);
    CHECK_THAT(at(t_s), WithinAbs(c - 0.5 * rate * std::clamp(t_s - 4.0, 0.0, 1.0), 1e-12));
  }
  // A rudder that turns half as fast follows what moved in the middle.
  RudderResponse slow;
  slow.rate_radps = 0.5 * rate;
  const RecordedInputs followed = inputs.through(slow);
  CHECK_THAT(followed.at(4.2).actuators[Channel::delta], WithinAbs(c, 1e-12));
  CHECK_THAT(followed.at(5.25).actuators[Channel::delta], WithinAbs(d, 0.02 * rate));
  CHECK_THAT(at(6.5), WithinAbs(d - 0.025 * rate, 1e-12));
  CHECK_THAT(at(7.5), WithinAbs(d - 0.075 * rate, 1e-12));
}

TEST_CASE("replay: of a zigzag that is sampled once a second less is lost at the actuators' own rate", "[dynamics]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const auto maneuver = zigzag(ship, 20.0 * kDegree, 20.0 * kDegree);
  const Trajectory truth = simulate(SimulatedShip(ship), *maneuver, {}, {0.1, 1.0, 100.0});
  // As far from the truth as the positions after 100 s.
  const auto error = [&](InputInterpolation between) {
    const Trajectory run = replay(ship, truth, {truth, ship, between}, {0.1, 1.0, 100.0});
    return std::hypot(run[Channel::x0].back() - truth[Channel::x0].back(),
                      run[Channel::y0].back() - truth[Channel::y0].back());
  };
  const double known = error(InputInterpolation::at_actuator_rate), even = error(InputInterpolation::linear);
  CAPTURE(known, even);
  CHECK(known < 0.6 * even);
}

TEST_CASE("replay: inputs are found between samples however unevenly these lie", "[dynamics]") {
  const Ship ship = read_ship("esso-osaka-3m");
  Trajectory recording;
  recording.file = "uneven.csv";
  double t_s = 5.0;
  for (int i = 0; i < 400; ++i) {
    recording[Channel::t].push_back(t_s);
    recording[Channel::n_p].push_back(3.0 + 0.02 * t_s);  // linear: the right place gives it back
    for (const Channel channel : {Channel::u, Channel::vm, Channel::r, Channel::delta})
      recording[channel].push_back(0.1);
    t_s += i % 50 == 49 ? 30.0 : 0.1 + 0.01 * (i % 7);
  }
  const RecordedInputs inputs(recording, ship, InputInterpolation::linear);
  const double end_s = recording[Channel::t].back();
  for (int i = 0; i <= 5000; ++i) {
    const double at_s = 5.0 + (end_s - 5.0) * i / 5000.0;
    CHECK_THAT(inputs.at(at_s).actuators[Channel::n_p], WithinAbs(3.0 + 0.02 * at_s, 1e-11));
  }
  for (const double sample_s : recording[Channel::t])
    CHECK_THAT(inputs.at(sample_s).actuators[Channel::n_p], WithinAbs(3.0 + 0.02 * sample_s, 1e-11));
  CHECK(inputs.at(0.0).actuators[Channel::n_p] == recording[Channel::n_p].front());
  CHECK(inputs.at(end_s + 9.0).actuators[Channel::n_p] == recording[Channel::n_p].back());
}

TEST_CASE("replay: it starts at the first complete sample, and refuses what it cannot know", "[dynamics]") {
  const Ship ship = read_ship("vectwin-3m");
  Trajectory recording = recorded(ship, 1.0);
  recording[Channel::u][0] = kMissing;
  recording[Channel::n_bt][1] = recording[Channel::n_bt][0] = kMissing;
  const RecordedInputs inputs(recording, ship, InputInterpolation::linear);
  const Trajectory result = replay(ship, recording, inputs, {0.1, 1.0, 1.0});
  CHECK(result[Channel::t].front() == 2.0);
  CHECK(result[Channel::u].front() == recording[Channel::u][2]);
  CHECK(result[Channel::t].back() == 120.0);

  Trajectory lacking = recorded(ship, 1.0);
  lacking[Channel::delta_s].clear();
  CHECK_THROWS_WITH(RecordedInputs(lacking, ship, InputInterpolation::linear),
                    Catch::Contains("no column 'delta_s_deg'") && Catch::Contains("; found actuators: "));
  Trajectory unknown = recorded(ship, 1.0);
  for (double& x : unknown[Channel::n_p]) x = kMissing;
  const RecordedInputs nothing(unknown, ship, InputInterpolation::linear);
  CHECK_THROWS_AS(replay(ship, unknown, nothing, {0.1, 1.0, 1.0}), InputError);
}

TEST_CASE("replay: a recording without a thruster's column is of the ship with the thruster idle", "[dynamics]") {
  const Ship with = read_ship("esso-osaka-3m");
  Ship without = with;
  without.modules->thrusters.clear();
  std::erase_if(without.actuators, [](const Actuator& a) { return a.is_optional; });
  const Trajectory recording = recorded(without, 1.0);
  REQUIRE_FALSE(recording.has(Channel::n_bt));
  const Trajectory a = replay(with, recording, {recording, with, InputInterpolation::linear}, {0.1, 1.0, 1.0});
  const Trajectory b = replay(without, recording, {recording, without, InputInterpolation::linear}, {0.1, 1.0, 1.0});
  CHECK(a.columns == b.columns);
}

TEST_CASE("replay: a thruster's column that is there counts, and its missing samples are not zero", "[dynamics]") {
  const Ship ship = read_ship("esso-osaka-3m");
  Trajectory recording = recorded(ship, 1.0);
  recording[Channel::n_bt].assign(recording.size(), kMissing);
  recording[Channel::n_st].clear();
  CHECK_FALSE(RecordedInputs(recording, ship, InputInterpolation::linear).first_known().has_value());
  recording[Channel::n_bt][3] = 12.0;
  recording[Channel::n_bt][5] = -8.0;
  const RecordedInputs inputs(recording, ship, InputInterpolation::linear);
  CHECK(inputs.channels() == std::vector{Channel::delta, Channel::n_p, Channel::n_bt});
  CHECK(inputs.first_known() == 3u);
  CHECK(inputs.at(4.0).actuators[Channel::n_bt] == 12.0);
  CHECK(inputs.at(50.0).actuators[Channel::n_bt] == -8.0);
  CHECK(inputs.at(50.0).actuators[Channel::n_st] == 0.0);
  const Trajectory result = replay(ship, recording, inputs, {0.1, 1.0, 1.0});
  CHECK(result[Channel::n_bt].back() == -8.0);
  CHECK_FALSE(result.has(Channel::n_st));
}

TEST_CASE("noise: it has the stated deviation and leaves actuators alone", "[dynamics]") {
  Trajectory truth;
  const std::size_t n = 20000;
  for (const Channel c : {Channel::t, Channel::u, Channel::r, Channel::psi, Channel::n_p}) truth[c].assign(n, 0.3);
  const ObservationNoise noise = read_noise("paper-model-scale");
  const Trajectory noisy = observed(truth, noise, {1, "observation noise"});
  const auto sd = [&](Channel c) {
    double sum = 0.0;
    for (const double x : noisy[c]) sum += (x - 0.3) * (x - 0.3);
    return std::sqrt(sum / static_cast<double>(n));
  };
  CHECK_THAT(sd(Channel::u), WithinAbs(0.01, 0.01 * 0.02));  // 4 standard errors of a deviation from 20000 values
  CHECK_THAT(sd(Channel::r), WithinAbs(0.1 * kDegree, 0.1 * kDegree * 0.02));
  CHECK_THAT(sd(Channel::psi), WithinAbs(0.1 * kDegree, 0.1 * kDegree * 0.02));
  CHECK(noisy[Channel::n_p] == truth[Channel::n_p]);
  CHECK(noisy[Channel::x0].empty());
}
