#include "dynamics/berthing.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"

using namespace leeway;

namespace {

struct Run {
  BerthingPlan plan;
  Trajectory trajectory;
};

Run berth(const Ship& ship, std::uint64_t seed, double duration_s, const WindProcess& wind = {}) {
  const BerthingPlan plan = draw_berthing(ship, {seed, "plan"});
  const SimulatedShip start = ship_at_start(ship, plan.steering);
  const auto pilot = berthing(start.ship, plan, {seed, "pilot"});
  return {plan, simulate(start, *pilot, wind, {0.1, 1.0, duration_s})};
}

double last(const Run& run, Channel channel) { return run.trajectory[channel].back(); }

bool is_berthed(const Run& run, double L_pp) {
  const double distance = std::hypot(last(run, Channel::x0), last(run, Channel::y0));
  const double speed = std::hypot(last(run, Channel::u), last(run, Channel::vm));
  return distance < 0.5 * L_pp && speed < 0.025 * std::sqrt(kGravity_mps2 * L_pp) * 0.5;
}

}  // namespace

TEST_CASE("berthing: pilots reach the berth slowly, from all patterns and on both sides, hardly ever astern",
          "[dynamics][berthing]") {
  const Ship ship = read_ship("vectwin-3m");
  std::set<BerthingPattern> patterns;
  std::set<bool> sides;
  std::size_t berthed = 0, to_berth = 0, samples = 0, astern = 0, clearly_astern = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    CAPTURE(seed);
    const WindProcess wind =
        WindProcess::stochastic(0.025 * static_cast<double>(seed), static_cast<double>(seed), {seed, "wind"});
    const Run run = berth(ship, seed, 250.0, wind);
    patterns.insert(run.plan.pattern);
    sides.insert(run.plan.is_starboard_side);
    if (run.plan.pattern != BerthingPattern::leave) {
      ++to_berth;
      berthed += is_berthed(run, 3.0);
    }
    for (std::size_t i = 0; i < run.trajectory.size(); ++i) {
      const double u = run.trajectory[Channel::u][i];
      ++samples;
      astern += u < 0.0;
      clearly_astern += u < -0.02;
      // A pilot's speeds: nothing wild.
      CHECK(std::abs(u) < 0.5);
      CHECK(std::abs(run.trajectory[Channel::vm][i]) < 0.12);
      CHECK(std::abs(run.trajectory[Channel::r][i]) < 5.0 * kDegree);
    }
  }
  CHECK(patterns.size() == kBerthingPatterns.size());
  CHECK(sides.size() == 2);
  CHECK(static_cast<double>(berthed) > 0.8 * static_cast<double>(to_berth));
  CHECK(static_cast<double>(astern) < 0.15 * static_cast<double>(samples));
  CHECK(static_cast<double>(clearly_astern) < 0.03 * static_cast<double>(samples));
}

TEST_CASE("berthing: orders are rounded, come at human intervals and leave the propeller alone",
          "[dynamics][berthing]") {
  const Ship ship = read_ship("vectwin-3m");
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    CAPTURE(seed);
    const BerthingPlan plan = draw_berthing(ship, {seed, "plan"});
    SimulatedShip ahead = ship_at_start(ship, plan.steering);
    const auto pilot = berthing(ship, plan, {seed, "pilot"});
    Actuators<double> command = ahead.actuators;
    double last_order_s = 0.0;
    int orders = 0;
    for (int k = 0; k < 2000; ++k) {
      const Actuators<double> before = command;
      const double t_s = grid_time(static_cast<std::size_t>(k), 0.1);
      pilot->order(t_s, ahead.state, command);
      CHECK(command[Channel::n_p] == before[Channel::n_p]);
      if (command.values != before.values) {
        CHECK(t_s - last_order_s > 1.8);
        last_order_s = t_s;
        ++orders;
        for (const Channel rudder : {Channel::delta_p, Channel::delta_s}) {
          const double steps = command[rudder] / (5.0 * kDegree);
          CHECK(std::abs(steps - std::round(steps)) < 1e-9);
        }
        const double steps = command[Channel::n_bt] / 2.5;
        CHECK(std::abs(steps - std::round(steps)) < 1e-9);
      }
      ahead.step(command, Vec2<double>::Zero(), 0.1);
    }
    CHECK(orders > 10);
    CHECK(orders < 60);
  }
}

TEST_CASE("berthing: the same seed gives the same run, another one another", "[dynamics][berthing]") {
  const Ship ship = read_ship("vectwin-3m");
  const Run once = berth(ship, 5, 100.0), again = berth(ship, 5, 100.0), other = berth(ship, 6, 100.0);
  CHECK(once.trajectory[Channel::u] == again.trajectory[Channel::u]);
  CHECK(once.trajectory[Channel::delta_p] == again.trajectory[Channel::delta_p]);
  CHECK(once.trajectory[Channel::psi] != other.trajectory[Channel::psi]);
  CHECK(once.plan.steering.start != other.plan.steering.start);
}

TEST_CASE("berthing: a full-scale plan is the model's in Froude's scale, and full-scale pilots reach the berth",
          "[dynamics][berthing]") {
  const Ship model = read_ship("vectwin-3m"), full = read_ship("vectwin-150m");
  std::size_t berthed = 0, to_berth = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    CAPTURE(seed);
    const BerthingPlan small = draw_berthing(model, {seed, "plan"});
    const Run run = berth(full, seed, 1760.0);
    CHECK(run.plan.steering.u0_mps == Approx(small.steering.u0_mps * std::sqrt(50.0)));
    CHECK(run.plan.steering.start(0) == Approx(50.0 * small.steering.start(0)).margin(1e-9));
    CHECK(run.plan.steering.start(2) == small.steering.start(2));
    CHECK(run.plan.steering.pilot.interval_s == Approx(small.steering.pilot.interval_s * std::sqrt(50.0)));
    if (run.plan.pattern == BerthingPattern::leave) continue;
    ++to_berth;
    berthed += is_berthed(run, 150.0);
  }
  CHECK(static_cast<double>(berthed) >= 0.7 * static_cast<double>(to_berth));
}

TEST_CASE("berthing: a ship without VecTwin rudders or bow thruster is refused", "[dynamics][berthing]") {
  for (const char* name : {"kvlcc2-l7", "esso-osaka-3m"})
    CHECK_THROWS_AS(draw_berthing(read_ship(name), {1, "plan"}), UsageError);
}
