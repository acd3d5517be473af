#include <catch2/catch.hpp>

#include "dynamics/model_parts.hpp"
#include "dynamics/replay.hpp"
#include "effect_runs.hpp"

using namespace leeway;
using namespace leeway::test;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

// A rudder that is put over by 20 deg within a sample at t = 10 s.
Trajectory step_of_rudder() {
  Trajectory recording;
  recording.file = "step.csv";
  for (int k = 0; k <= 600; ++k) {
    const double t_s = 0.1 * k;
    for (const auto& [channel, value] : {std::pair{Channel::t, t_s},
                                         {Channel::u, 0.5},
                                         {Channel::vm, 0.0},
                                         {Channel::r, 0.0},
                                         {Channel::psi, 0.0},
                                         {Channel::n_p, 10.0},
                                         {Channel::delta, t_s > 10.05 ? 20.0 * kDegree : 0.0}})
      recording[channel].push_back(value);
  }
  return recording;
}

}  // namespace

TEST_CASE("rudder response: a lag approaches a step exponentially, a limited rate in a straight line", "[effects]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const RecordedInputs recorded(step_of_rudder(), ship, InputInterpolation::linear);
  const auto angle = [&](const RudderResponse& response, double t_s) {
    return recorded.through(response).at(t_s).actuators[Channel::delta] / kDegree;
  };
  // The step is linear between 10.0 and 10.1 s: as if at its middle.
  for (const double t_s : {12.0, 15.0, 25.0})
    CHECK_THAT(angle({.lag_s = 3.0}, t_s), WithinAbs(20.0 * (1.0 - std::exp(-(t_s - 10.05) / 3.0)), 0.01));
  for (const double t_s : {11.0, 14.0})
    CHECK_THAT(angle({.rate_radps = 4.0 * kDegree}, t_s), WithinAbs(4.0 * (t_s - 10.0), 0.02));
  CHECK_THAT(angle({.rate_radps = 4.0 * kDegree}, 20.0), WithinAbs(20.0, 1e-9));
  CHECK_THAT(angle({.delay_s = 2.0, .rate_radps = 4.0 * kDegree}, 14.0), WithinAbs(8.0, 0.02));
  // Slower than both.
  CHECK(angle({.rate_radps = 4.0 * kDegree, .lag_s = 3.0}, 14.0) < angle({.lag_s = 3.0}, 14.0));
  // None is what is recorded, and other actuators stay as they are.
  CHECK(angle({}, 10.07) == recorded.at(10.07).actuators[Channel::delta] / kDegree);
  CHECK(recorded.through({.lag_s = 3.0}).at(12.0).actuators[Channel::n_p] == 10.0);
}

TEST_CASE("actuator rate and lag: a maneuver and the replay of its recording agree", "[effects]") {
  const Ship ship = read_ship("vectwin-3m");
  for (const auto& [type, parameters] : {std::pair<std::string, Parameters>{"actuator-rate", {{"rate_degps", 3.0}}},
                                         {"actuator-lag", {{"lag_s", 1.5}}}}) {
    CAPTURE(type);
    const Ship slow = with(ship, type, parameters);
    Trajectory recording = run(slow, 60.0, 0.1);
    recording.file = "slow.csv";
    CHECK(recording[Channel::delta_s] == run(ship, 60.0, 0.1)[Channel::delta_s]);  // recorded is what was before
    const RecordedInputs inputs(recording, slow, InputInterpolation::linear);
    const Trajectory again = replay(slow, recording, inputs, {0.1, 0.1, 0.1});
    CHECK(largest_difference(again, recording, Channel::r) < 3e-4);
    CHECK(largest_difference(again, recording, Channel::delta_s) < 1e-12);
    CHECK(largest_difference(replay(ship, recording, inputs, {0.1, 0.1, 0.1}), recording, Channel::r) > 3e-3);
  }
  // Faster than the rudders themselves, it is not there.
  Trajectory fast = run(with(ship, "actuator-rate", {{"rate_degps", 1000.0}}), 60.0, 0.1);
  CHECK(largest_difference(fast, run(ship, 60.0, 0.1), Channel::r) < 1e-4);
}

TEST_CASE("actuator delay: the rudder acts later, in a maneuver and in the replay of its recording", "[effects]") {
  const Ship ship = read_ship("vectwin-3m"), late = with(ship, "actuator-delay", {{"delay_s", 1.25}});
  Trajectory recording = run(late, 60.0, 0.1);
  recording.file = "late.csv";
  // What is recorded is what the undelayed rudders do.
  CHECK(recording[Channel::delta_s] == run(ship, 60.0, 0.1)[Channel::delta_s]);
  const RecordedInputs inputs(recording, late, InputInterpolation::linear);
  const Trajectory again = replay(late, recording, inputs, {0.1, 0.1, 0.1});
  CHECK(largest_difference(again, recording, Channel::r) < 2e-4);
  CHECK(largest_difference(replay(ship, recording, inputs, {0.1, 0.1, 0.1}), recording, Channel::r) > 5e-3);
  CHECK(largest_difference(again, recording, Channel::delta_s) < 1e-12);

  // The rudder's angle of 1.25 s ago acts; before the start the first one.
  const RecordedInputs late_inputs = inputs.through({.delay_s = 1.25});
  const StepInputs<double> step = late_inputs.step(30.0, 0.1);
  CHECK_THAT(step.start.actuators[Channel::delta_p], WithinAbs(inputs.at(28.75).actuators[Channel::delta_p], 1e-12));
  CHECK_THAT(step.end.actuators[Channel::n_bt], WithinAbs(inputs.at(30.1).actuators[Channel::n_bt], 1e-12));
  CHECK(late_inputs.step(0.5, 0.1).start.actuators[Channel::delta_p] == recording[Channel::delta_p][0]);
}

TEST_CASE("rudder latency: the angles are recorded late, in a maneuver, and act before in its replay", "[effects]") {
  const Ship ship = read_ship("vectwin-3m"), late = with(ship, "rudder-latency", {{"rudder_latency_s", 1.25}});
  const Trajectory truth = run(ship, 60.0, 0.1);
  Trajectory recording = run(late, 60.0, 0.1);
  recording.file = "late.csv";
  // The ship sails as she does; her angles are those of 1.25 s ago, before the start the first ones.
  CHECK(recording[Channel::r] == truth[Channel::r]);
  CHECK(recording[Channel::n_bt] == truth[Channel::n_bt]);
  for (const std::size_t k : {20, 150, 600})
    CHECK_THAT(recording[Channel::delta_s][k],
               WithinAbs(0.5 * (truth[Channel::delta_s][k - 12] + truth[Channel::delta_s][k - 13]), 0.1 * kDegree));
  CHECK(recording[Channel::delta_s][5] == truth[Channel::delta_s][0]);
  const RecordedInputs inputs(recording, late, InputInterpolation::linear);
  const Trajectory again = replay(late, recording, inputs, {0.1, 0.1, 0.1});
  const auto until = [](Trajectory run, std::size_t samples) {  // behind, angles are not recorded any more
    for (std::vector<double>& column : run.columns)
      if (!column.empty()) column.resize(samples);
    return run;
  };
  CHECK(largest_difference(until(again, 585), until(recording, 585), Channel::r) < 2e-4);
  CHECK(largest_difference(replay(ship, recording, inputs, {0.1, 0.1, 0.1}), recording, Channel::r) > 5e-3);
}

TEST_CASE("unknown: terms give the force of their formula, and nothing where all are zero", "[effects]") {
  const Ship ship = read_ship("vectwin-3m");
  const Particulars& p = ship.particulars;
  const double q = 0.5 * p.rho * p.L_pp * p.d;
  Situation<double> at = at_heading(30.0);
  Actuators<double> actuators = ship.initial_actuators();
  actuators[Channel::delta_p] = actuators[Channel::delta_s] = 0.3;
  actuators[Channel::n_p] = 10.0;
  at.actuators = &actuators;
  const auto force = [&](const Parameters& parameters) {
    return Effects<double>(with(ship, "unknown", parameters)).force(at);
  };
  const double u = at.nu_water(0), v = at.nu_water(1), w = at.nu_water(2) * p.L_pp;
  CHECK(force({}) == Vec3<double>::Zero());
  CHECK_THAT(force({{"X_vr", 0.2}})(0), WithinRel(q * 0.2 * v * w, 1e-12));
  CHECK_THAT(force({{"Y_vv", 0.3}})(1), WithinRel(q * 0.3 * v * std::abs(v), 1e-12));
  CHECK_THAT(force({{"N_d", 0.1}})(2), WithinRel(q * p.L_pp * 0.1 * u * u * std::sin(0.3), 1e-12));
  CHECK_THAT(force({{"Y_nd", 0.01}})(1), WithinRel(q * 0.01 * std::pow(10.0 * p.d, 2) * std::sin(0.3), 1e-12));
  CHECK_THAT(force({{"X_sqrt_u", 0.001}})(0),
             WithinRel(q * 0.001 * std::sqrt(u) * std::pow(kGravity_mps2 * p.L_pp, 0.75), 1e-12));
}
