#include "dynamics/port_navigation.hpp"

#include <cmath>
#include <set>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"

using namespace leeway;

namespace {

constexpr double kDuration_s = 1250.0;  // the mean of the paper's port navigations at full scale

struct PortRun {
  PortPlan plan;
  Trajectory trajectory;
  const std::vector<double>& operator[](Channel channel) const { return trajectory[channel]; }
  double last(Channel channel) const { return trajectory[channel].back(); }
};

PortRun navigate(const Ship& ship, std::uint64_t seed, double duration_s, double wind_mps = 0.0) {
  const PortPlan plan = draw_port_navigation(ship, duration_s, {seed, "plan"});
  const SimulatedShip start = ship_at_start(ship, plan.steering);
  const auto pilot = port_navigation(start.ship, plan, duration_s, {seed, "pilot"});
  const WindProcess wind = WindProcess::stochastic(wind_mps, static_cast<double>(seed), {seed, "wind"});
  return {plan, simulate(start, *pilot, wind, {0.1, 1.0, duration_s})};
}

}  // namespace

TEST_CASE("port navigation: the ship comes in at harbor speed, makes the course changes and ends slow near the berth",
          "[dynamics][port]") {
  const Ship ship = read_ship("vectwin-150m");
  const double L = ship.particulars.L_pp;
  std::set<std::string_view> ports;
  std::set<PortEnd> ends;
  int near = 0, runs = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    CAPTURE(seed);
    const PortRun run = navigate(ship, seed, kDuration_s, 0.25 * static_cast<double>(seed));
    ports.insert(run.plan.port);
    ends.insert(run.plan.end);
    ++runs;
    // The revolutions give 3.64 m/s with the rudders amidships.
    CHECK(run[Channel::u].front() > 2.7);
    CHECK(run[Channel::u].front() < 3.64);
    CHECK(run.last(Channel::u) < 0.8);
    near += std::hypot(run.last(Channel::x0), run.last(Channel::y0)) < L;

    REQUIRE(!run.plan.course_changes.empty());
    CHECK(run.plan.course_changes.size() <= 3);
    for (const double angle : run.plan.course_changes) CHECK(std::abs(angle) > 20.0 * kDegree);
    // The moored ship's heading is reached by all turns together, those on the spot included.
    CHECK(std::abs(wrap_angle(run.last(Channel::psi) - run.plan.quay_heading)) < 25.0 * kDegree);
    for (const double u : run[Channel::u]) CHECK(u > 0.0);  // some headway is kept
  }
  CHECK(ports.size() == 3);
  CHECK(ends.size() == kPortEnds.size());
  CHECK(near >= 0.75 * runs);
}

TEST_CASE("port navigation: one after the other the course changes are made", "[dynamics][port]") {
  const Ship ship = read_ship("vectwin-150m");
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    CAPTURE(seed);
    const PortRun run = navigate(ship, seed, kDuration_s);
    std::size_t at = 0;
    double before = run.plan.steering.legs.front().pose(2);
    for (const PilotLeg& leg : run.plan.steering.legs) {
      if (leg.kind != PilotLeg::Kind::fairway) break;
      // The start is up to 5 deg off. On a short piece the next turn begins before the last one is finished: two
      // thirds of each are made.
      const double heading = leg.pose(2), most_off = 6.0 * kDegree + std::abs(heading - before) / 3.0;
      const auto is_off = [&] { return std::abs(wrap_angle(run[Channel::psi][at] - heading)) > most_off; };
      while (at + 1 < run.trajectory.size() && is_off()) ++at;
      CHECK_FALSE(is_off());
      before = heading;
    }
  }
}

TEST_CASE("port navigation: in the fairway both rudders turn together, and they turn the ship", "[dynamics][port]") {
  const Ship ship = read_ship("vectwin-150m");
  std::size_t samples = 0, closed = 0, put_over = 0, well_over = 0;
  double most = 0.0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const PortRun run = navigate(ship, seed, kDuration_s, 3.0);
    for (std::size_t i = 0; i < run.trajectory.size(); ++i) {
      const double p = run[Channel::delta_p][i], s = run[Channel::delta_s][i];
      ++samples;
      if (0.5 * (s - p) > 15.1 * kDegree) continue;
      const double together = 0.5 * std::abs(s + p);
      ++closed;
      put_over += together > 4.9 * kDegree;
      well_over += together > 9.9 * kDegree;
      most = std::max(most, together);
    }
  }
  // Shares that let a network learn what equal angles do; rudders put wide open turn the ship the other way.
  CHECK(static_cast<double>(closed) > 0.25 * static_cast<double>(samples));
  CHECK(static_cast<double>(put_over) > 0.4 * static_cast<double>(closed));
  CHECK(static_cast<double>(well_over) > 0.1 * static_cast<double>(closed));
  CHECK(most > 24.0 * kDegree);
}

TEST_CASE("port navigation: orders are rounded, come a reaction time after a look, and leave the propeller alone",
          "[dynamics][port]") {
  const Ship ship = read_ship("vectwin-150m");
  const double step = 5.0 * kDegree;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    CAPTURE(seed);
    const PortPlan plan = draw_port_navigation(ship, kDuration_s, {seed, "plan"});
    const PilotTraits& traits = plan.steering.pilot;
    SimulatedShip ahead = ship_at_start(ship, plan.steering);
    const auto pilot = port_navigation(ship, plan, kDuration_s, {seed, "pilot"});
    Actuators<double> command = ahead.actuators;
    double last_s = 0.0;
    int orders = 0;
    for (std::size_t k = 0; k < 12500; ++k) {
      const Actuators<double> before = command;
      const double t_s = grid_time(k, 0.1);
      pilot->order(t_s, ahead.state, command);
      CHECK(command[Channel::n_p] == before[Channel::n_p]);
      if (command.values != before.values) {
        if (orders == 0) CHECK(t_s >= traits.reaction_s);
        if (orders > 0) CHECK(t_s - last_s > 0.7 * traits.interval_s - 0.11);  // rounded to the time step
        last_s = t_s;
        ++orders;
        for (const Channel rudder : {Channel::delta_p, Channel::delta_s})
          CHECK(std::abs(command[rudder] / step - std::round(command[rudder] / step)) < 1e-9);
      }
      ahead.step(command, Vec2<double>::Zero(), 0.1);
    }
    CHECK(orders > 20);
    CHECK(orders < kDuration_s / (0.7 * traits.interval_s));
  }
}

TEST_CASE("port navigation: the same seed gives the same run, no two seeds give one", "[dynamics][port]") {
  const Ship ship = read_ship("vectwin-150m");
  const PortRun once = navigate(ship, 5, 300.0), again = navigate(ship, 5, 300.0);
  CHECK(once[Channel::u] == again[Channel::u]);
  CHECK(once[Channel::delta_p] == again[Channel::delta_p]);
  std::set<double> starts;
  for (std::uint64_t seed = 1; seed <= 41; ++seed)
    starts.insert(draw_port_navigation(ship, kDuration_s, {seed, "plan"}).steering.start(0));
  CHECK(starts.size() == 41);
}

TEST_CASE("port navigation: a plan for the model is the ship's by Froude's law", "[dynamics][port]") {
  const Ship model = read_ship("vectwin-3m"), full = read_ship("vectwin-150m");
  const double time = std::sqrt(50.0);
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    CAPTURE(seed);
    const PortPlan small = draw_port_navigation(model, 180.0, {seed, "plan"});
    const PortPlan large = draw_port_navigation(full, 180.0 * time, {seed, "plan"});
    CHECK(large.steering.u0_mps == Approx(small.steering.u0_mps * time));
    CHECK(large.steering.start(0) == Approx(50.0 * small.steering.start(0)));
    CHECK(large.steering.start(2) == Approx(small.steering.start(2)));
    CHECK(large.steering.pilot.interval_s == Approx(small.steering.pilot.interval_s * time));
    CHECK(large.course_changes == small.course_changes);
  }
}

TEST_CASE("port navigation: a ship without VecTwin rudders or bow thruster is refused", "[dynamics][port]") {
  for (const char* name : {"kvlcc2-l7", "esso-osaka-3m", "ferry-40m"})
    CHECK_THROWS_AS(draw_port_navigation(read_ship(name), 200.0, {1, "plan"}), UsageError);
}
