#include "dynamics/scaled_replay.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "dynamics/port_navigation.hpp"

using namespace leeway;

namespace {

constexpr double kRatio = 50.0;

Trajectory at_full_scale(std::uint64_t seed, double duration_s) {
  const Ship ship = read_ship("vectwin-150m");
  const PortPlan plan = draw_port_navigation(ship, duration_s, {seed, "plan"});
  const SimulatedShip start = ship_at_start(ship, plan.steering);
  const auto pilot = port_navigation(start.ship, plan, duration_s, {seed, "pilot"});
  return simulate(start, *pilot, {}, {0.1, 1.0, duration_s});
}

// A run with one sample per second.
Trajectory run_of(std::vector<double> u, std::vector<double> r) {
  Trajectory run;
  for (std::size_t i = 0; i < u.size(); ++i) run[Channel::t].push_back(static_cast<double>(i));
  run[Channel::vm].assign(u.size(), 0.0);
  run[Channel::u] = std::move(u);
  run[Channel::r] = std::move(r);
  return run;
}

}  // namespace

TEST_CASE("scaled replay: inputs and first state are the ship's by Froude's law", "[dynamics][port]") {
  const Trajectory full = at_full_scale(3, 900.0);
  const FroudeLaw law(kRatio);
  const Trajectory run =
      replay_to_scale(read_ship("vectwin-3m"), full, law, WindProcess::steady(0.3, 1.0), {0.1, 1.0, 127.0});
  REQUIRE(run.size() == 128);
  const double time = std::sqrt(kRatio);
  CHECK(run[Channel::u][0] == Approx(full[Channel::u][0] / time));
  CHECK(run[Channel::x0][0] == Approx(full[Channel::x0][0] / kRatio));
  CHECK(run[Channel::psi][0] == Approx(full[Channel::psi][0]));
  for (std::size_t k = 0; k < run.size(); ++k) {
    const double t_s = static_cast<double>(k) * time;
    const auto before = static_cast<std::size_t>(t_s);
    const double weight = t_s - static_cast<double>(before);
    const auto at = [&](Channel channel) {
      return (1.0 - weight) * full[channel][before] + weight * full[channel][before + 1];
    };
    CAPTURE(k);
    CHECK(run[Channel::t][k] == static_cast<double>(k));
    CHECK(run[Channel::delta_p][k] == Approx(at(Channel::delta_p)).margin(1e-9));
    CHECK(run[Channel::delta_s][k] == Approx(at(Channel::delta_s)).margin(1e-9));
    CHECK(run[Channel::n_p][k] == Approx(at(Channel::n_p) * time));
    CHECK(run[Channel::n_bt][k] == Approx(at(Channel::n_bt) * time).margin(1e-9));
    CHECK(run[Channel::wind_speed][k] == Approx(0.3));
  }
}

TEST_CASE("scaled replay: in calm air the model does what the ship did", "[dynamics][port]") {
  const Trajectory full = at_full_scale(4, 900.0);
  const FroudeLaw law(kRatio);
  const Trajectory run = replay_to_scale(read_ship("vectwin-3m"), full, law, {}, {0.1, 1.0, 127.0});
  const double time = std::sqrt(kRatio);
  for (std::size_t k = 0; k < run.size(); k += 9) {
    CAPTURE(k);
    const auto at = static_cast<std::size_t>(std::lround(static_cast<double>(k) * time));
    // Air is lighter by the sea water, and inputs are linear between samples of the ship: together below 0.01 m/s.
    CHECK(run[Channel::u][k] == Approx(full[Channel::u][at] / time).margin(0.01));
    CHECK(run[Channel::vm][k] == Approx(full[Channel::vm][at] / time).margin(0.01));
  }
  CHECK(is_like(run, scaled_down(full, law)));
}

TEST_CASE("scaled replay: sternway, and speed or yaw rate far beyond the run's, are stated", "[dynamics][port]") {
  const std::vector<double> u(200, 0.3), r(200, 0.02);
  const Trajectory scaled = run_of(u, r);
  CHECK(is_like(scaled, scaled));
  std::vector<double> astern = u;
  astern[100] = astern[101] = -0.001;
  CHECK(is_like(run_of(astern, r), scaled));  // 1 % of the time
  astern[102] = -0.001;
  CHECK_FALSE(is_like(run_of(astern, r), scaled));
  for (const auto& [factor, is_kept] : {std::pair{1.29, true}, std::pair{1.31, false}}) {
    CAPTURE(factor);
    std::vector<double> fast = u, turning = r;
    fast[50] *= factor;
    turning[50] *= -factor;
    CHECK(is_like(run_of(fast, r), scaled) == is_kept);
    CHECK(is_like(run_of(u, turning), scaled) == is_kept);
  }
}
