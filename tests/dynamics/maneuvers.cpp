#include "dynamics/maneuvers.hpp"

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/phased_maneuvers.hpp"
#include "dynamics/schedule.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using leeway::test::TemporaryFolder;

namespace {

Trajectory run(const SimulatedShip& start, Maneuver& maneuver, double sample_s = 1.0) {
  return simulate(start, maneuver, {},
                  {0.1, sample_s, sample_s * std::ceil(maneuver.longest_s().value_or(200.0) / sample_s)});
}

double value_at(const Trajectory& t, Channel channel, double t_s) {
  for (std::size_t k = 0; k < t.size(); ++k)
    if (std::abs(t[Channel::t][k] - t_s) < 1e-6) return t[channel][k];
  FAIL("no sample at this time");
  return 0.0;
}

}  // namespace

TEST_CASE("pull-out: four phases, each left when the turn is steady, and then it is done", "[dynamics][maneuvers]") {
  const SimulatedShip start(read_ship("esso-osaka-3m"));
  const auto maneuver = pull_out(start, 15.0 * kDegree, -1.0 * kDegree);
  const Trajectory t = run(start, *maneuver, 0.1);
  const std::vector<Phase> phases = maneuver->phases();
  REQUIRE(phases.size() == 4);
  CHECK(maneuver->is_done());
  const double rudder_deg[] = {15.0, -1.0, -15.0, -1.0};
  for (std::size_t i = 0; i < 4; ++i) {
    CAPTURE(i);
    CHECK(phases[i].is_fulfilled);
    CHECK_THAT(value_at(t, Channel::delta, phases[i].end_s) / kDegree, WithinAbs(rudder_deg[i], 1e-6));
    // The yaw rate changed by less than the band over the last 5 L/u0 = 37.5 s.
    const double end = phases[i].end_s;
    CHECK_THAT(value_at(t, Channel::r, end), WithinAbs(value_at(t, Channel::r, end - 37.0), 0.001 * 0.4 / 3.0));
  }
  CHECK(t[Channel::t].back() < phases[3].end_s + 0.2);
}

TEST_CASE("spiral: the rudder goes stepwise to port and back, finely about amidships", "[dynamics][maneuvers]") {
  const SimulatedShip start(read_ship("vectwin-3m"));
  const auto maneuver = spiral(start, 15.0 * kDegree, 5.0 * kDegree, 2.5 * kDegree, 20.0);
  run(start, *maneuver);
  std::vector<double> degrees;
  for (const Phase& phase : maneuver->phases()) {
    degrees.push_back(std::round(10.0 * rad_to_deg(phase.order)) / 10.0);
    CHECK(phase.end_s - phase.start_s < 20.1);
  }
  CHECK(degrees == std::vector<double>{15, 10, 5, 2.5, 0, -2.5, -5, -10, -15, -10, -5, -2.5, 0, 2.5, 5, 10, 15});
  CHECK_THROWS_AS(spiral(start, 15.0 * kDegree, 4.0 * kDegree, 2.0 * kDegree), UsageError);
  CHECK_THROWS_AS(spiral(start, 15.0 * kDegree, 5.0 * kDegree, 2.0 * kDegree), UsageError);
  CHECK_THROWS_AS(spiral(start, 40.0 * kDegree, 5.0 * kDegree, 1.0 * kDegree), UsageError);  // beyond a rudder's limit
}

TEST_CASE("crash stop: by the propeller where it reverses, by clamshell rudders where it does not",
          "[dynamics][maneuvers]") {
  for (const char* name : {"esso-osaka-3m", "vectwin-3m", "kvlcc2-l7"}) {
    CAPTURE(name);
    const SimulatedShip start(read_ship(name));
    const auto maneuver = crash_stop(start, 20.0);
    const Trajectory t = run(start, *maneuver, 0.1);
    const std::vector<Phase> phases = maneuver->phases();
    REQUIRE(phases.size() == 2);
    CHECK_THAT(phases[1].start_s, WithinAbs(20.0, 1e-9));
    CHECK(phases[1].is_fulfilled);
    CHECK(t[Channel::u].back() <= 0.0);
    CHECK(*std::min_element(t[Channel::u].begin(), t[Channel::u].end() - 2) > -1e-3);
    // The approach is straight: heading within a degree.
    CHECK(std::abs(value_at(t, Channel::psi, 20.0)) < kDegree);
    if (t.has(Channel::delta)) {
      CHECK(t[Channel::n_p].back() < 0.0);
      CHECK(std::abs(t[Channel::delta].back()) < 1e-9);
    } else {
      CHECK_THAT(t[Channel::delta_p].back() / kDegree, WithinAbs(-105.0, 1e-6));
      CHECK_THAT(t[Channel::delta_s].back() / kDegree, WithinAbs(105.0, 1e-6));
      CHECK(t[Channel::n_p].back() == 10.0);
    }
  }
  Ship ship = read_ship("esso-osaka-3m");
  for (const double n : {3.0, 0.0, -21.0}) CHECK_THROWS_AS(crash_stop(SimulatedShip(ship), {}, n), UsageError);
  for (Actuator& actuator : ship.actuators)
    if (actuator.channel == Channel::n_p) actuator.min = 0.0;
  CHECK_THROWS_AS(crash_stop(SimulatedShip(ship)), UsageError);
}

TEST_CASE("coast-down: to a tenth of the speed, through revolutions that die away", "[dynamics][maneuvers]") {
  for (const char* name : {"esso-osaka-3m", "vectwin-3m"}) {
    CAPTURE(name);
    const SimulatedShip start(read_ship(name));
    const auto maneuver = coast_down(start);
    const Trajectory t = run(start, *maneuver);
    CHECK(maneuver->phases().at(0).is_fulfilled);
    const double U = std::hypot(t[Channel::u].back(), t[Channel::vm].back());
    CHECK(U <= 0.1 * start.state.nu(0));
    CHECK(U > 0.09 * start.state.nu(0));
    CHECK(t[Channel::n_p].back() < 1e-9);
  }
}

TEST_CASE("thruster pulses: each to its side, then a rest", "[dynamics][maneuvers]") {
  SimulatedShip start(read_ship("vectwin-3m"));
  start.state.nu(0) = 0.0;
  start.actuators[Channel::n_p] = 0.0;
  ThrusterPulses pulses = thruster_pulses_for(start.ship);
  CHECK(pulses.rps == 30.0);
  CHECK_THAT(pulses.pulse_s, WithinRel(40.0 * std::sqrt(3.0 / 9.80665), 1e-12));
  pulses.pulse_s = 10.0;
  pulses.rest_s = 15.0;
  pulses.rps = 20.0;
  pulses.pulses = 3;
  const auto maneuver = thruster_pulses(start, pulses);
  const Trajectory t = run(start, *maneuver);
  CHECK(t[Channel::t].back() == 75.0);
  for (const auto& [t_s, n] :
       {std::pair(9.0, 20.0), {24.0, 0.0}, {34.0, -20.0}, {49.0, 0.0}, {59.0, 20.0}, {74.0, 0.0}})
    CHECK_THAT(value_at(t, Channel::n_bt, t_s), WithinAbs(n, 1e-6));
  CHECK(value_at(t, Channel::r, 10.0) > 0.0);
  CHECK(value_at(t, Channel::psi, 35.0) - value_at(t, Channel::psi, 25.0) <
        value_at(t, Channel::psi, 10.0) - value_at(t, Channel::psi, 0.0));
  CHECK_THROWS_AS(thruster_pulses_for(read_ship("kvlcc2-l7")), UsageError);
  CHECK_THROWS_AS(thruster_pulses_for(start.ship, Channel::n_st), UsageError);
  pulses.rps = 31.0;
  CHECK_THROWS_AS(thruster_pulses(start, pulses), UsageError);
}

TEST_CASE("straight: the revolutions hold the speed, the controller the heading", "[dynamics][maneuvers]") {
  for (const char* name : {"esso-osaka-3m", "vectwin-3m", "kvlcc2-l7"})
    for (const double part : {0.5, 1.0}) {
      CAPTURE(name, part);
      const Ship ship = read_ship(name);
      const double u = part * ship.u0_mps;
      const SimulatedShip start = steady_ahead(ship, u);
      const auto maneuver = straight(start.ship, course_keeper(start));
      const Trajectory t = simulate(start, *maneuver, {}, {0.1, 1.0, 300.0});
      CHECK_THAT(t[Channel::u].back(), WithinRel(u, 1e-3));
      CHECK(std::abs(t[Channel::psi].back()) < 1.0 * kDegree);
      CHECK(std::abs(t[Channel::r].back()) < 1e-6);
    }
  // From 30 deg off its course, it comes back.
  SimulatedShip start = steady_ahead(read_ship("vectwin-3m"), 0.5);
  CourseKeeper keeper = course_keeper(start);
  start.state.eta(2) = 30.0 * kDegree;
  const auto maneuver = straight(start.ship, keeper);
  CHECK(std::abs(simulate(start, *maneuver, {}, {0.1, 1.0, 200.0})[Channel::psi].back()) < 1.0 * kDegree);
  CHECK_THROWS_AS(steady_ahead(start.ship, 5.0), NumericalError);
}

TEST_CASE("maneuvers of phases: they need a speed ahead", "[dynamics][maneuvers]") {
  SimulatedShip start(read_ship("esso-osaka-3m"));
  for (const double u : {0.0, -0.1}) {
    start.state.nu(0) = u;
    CHECK_THROWS_AS(pull_out(start, 0.3), UsageError);
    CHECK_THROWS_AS(spiral(start, 0.3, 0.1, 0.1), UsageError);
    CHECK_THROWS_AS(crash_stop(start), UsageError);
    CHECK_THROWS_AS(coast_down(start), UsageError);
    CHECK_THROWS_AS(course_keeper(start), UsageError);
  }
}

TEST_CASE("simulation: rows of every step do not change the run", "[dynamics][maneuvers]") {
  const SimulatedShip start(read_ship("vectwin-3m"));
  const auto once = [&](Trajectory* every_step) {
    const auto maneuver = crash_stop(start);
    return simulate(start, *maneuver, WindProcess::stochastic(1.0, 0.5, {2, "wind"}), {0.1, 1.0, 300.0},
                    Integrator::rk4, every_step);
  };
  Trajectory every_step;
  const Trajectory a = once(nullptr), b = once(&every_step);
  CHECK(a.columns == b.columns);
  REQUIRE(every_step.size() == 10 * (a.size() - 1) + 1);
  for (std::size_t k = 0; k < a.size(); ++k) CHECK(every_step[Channel::u][10 * k] == a[Channel::u][k]);
}

TEST_CASE("schedule: orders stand until they are replaced", "[dynamics][schedule]") {
  const TemporaryFolder folder;
  const Ship ship = read_ship("vectwin-3m");
  const Schedule schedule =
      read_schedule(folder.write("s.csv", "t_s, n_bt_rps,delta_p_deg\r\n2,,10\n20.05,-15,\n\n40,,-20\n"), ship);
  CHECK(schedule.notices.empty());
  const auto maneuver = scheduled_orders(schedule);
  CHECK(maneuver->longest_s() == 240.0);
  const Trajectory t = simulate(SimulatedShip(ship), *maneuver, {}, {0.1, 0.1, 60.0});
  CHECK(value_at(t, Channel::delta_p, 2.0) == 0.0);
  CHECK(value_at(t, Channel::delta_p, 2.1) > 0.0);
  CHECK_THAT(value_at(t, Channel::delta_p, 30.0) / kDegree, WithinAbs(10.0, 1e-9));
  CHECK(value_at(t, Channel::n_bt, 20.1) == 0.0);  // the order comes at the first step after 20.05 s
  CHECK(value_at(t, Channel::n_bt, 20.2) < 0.0);
  CHECK_THAT(value_at(t, Channel::n_bt, 60.0), WithinAbs(-15.0, 1e-9));
  CHECK_THAT(value_at(t, Channel::delta_p, 60.0) / kDegree, WithinAbs(-20.0, 1e-9));
  CHECK(value_at(t, Channel::delta_s, 60.0) == 0.0);
}

TEST_CASE("schedule: wrong files are named with line and column", "[dynamics][schedule]") {
  const TemporaryFolder folder;
  const Ship ship = read_ship("esso-osaka-3m");
  for (const auto& [text, message] : std::initializer_list<std::pair<const char*, const char*>>{
           {"", "empty"},
           {"delta_deg\n3\n", "no column 't_s'"},
           {"t_s\n3\n", "no column with orders; expected some of t_s, delta_deg, n_p_rps"},
           {"t_s,delta_deg\n", "expected at least one row"},
           {"t_s,delta_p_deg\n0,1\n", "column 'delta_p_deg': is no order of the ship 'esso-osaka-3m'"},
           {"t_s,u_mps\n0,1\n", "column 'u_mps'"},
           {"t_s,delta_deg\n0,1\n5,2\n5,3\n", "s.csv:4: column 't_s': expected a time later than 5 s, got 5"},
           {"t_s,delta_deg\n-1,1\n", "s.csv:2: column 't_s': expected a time >= 0 s"},
           {"t_s,delta_deg\n0,hard\n", "s.csv:2: column 'delta_deg': expected a finite number [deg], got 'hard'"},
           {"t_s,delta_deg\n0,nan\n", "got 'nan'"},
           {"t_s,delta_deg\n,3\n", "column 't_s': expected a finite number"},
           {"t_s,delta_deg\n0\n", "s.csv:2"}}) {
    CAPTURE(text);
    CHECK_THROWS_MATCHES(
        read_schedule(folder.write("s.csv", text), ship), InputError,
        Catch::Matchers::Predicate<InputError>(
            [&](const InputError& error) { return std::string(error.what()).find(message) != std::string::npos; },
            message));
  }
  const Schedule wild = read_schedule(folder.write("s.csv", "t_s,delta_deg\n0,35\n1,36\n2,-40\n"), ship);
  REQUIRE(wild.notices.size() == 1);
  CHECK_THAT(wild.notices[0], Contains("s.csv:3: column 'delta_deg': 2 orders outside the limits -35 to 35"));
}
