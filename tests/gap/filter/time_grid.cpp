#include "gap/filter/time_grid.hpp"

#include <catch2/catch.hpp>

#include "gap/filter/campaign.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;

namespace {

// Step of the grid for three random maneuvers, by the usual one: 2 sqrt(L/g).
double step_by_usual(const std::string& name, double sample_s, double noise) {
  const Ship ship = read_ship(name);
  std::vector<Trajectory> recordings;
  const double duration_s = std::round(120.0 * std::sqrt(ship.particulars.L_pp / 3.0));
  for (std::uint64_t i = 0; i < 3; ++i) {
    const auto orders = random_orders(ship, RandomStream(i, "orders"));
    Trajectory run = simulate(SimulatedShip(ship), *orders, {}, {0.1, sample_s, duration_s});
    run.name = run.file = std::to_string(i);
    recordings.push_back(observed(run, test::usual_noise(noise), RandomStream(i, "noise")));
  }
  return gap::prepare(ship, recordings, {}).step_s / (2.0 * std::sqrt(ship.particulars.L_pp / kGravity_mps2));
}

}  // namespace

TEST_CASE("time grid: means are over less time where the ship's corners show in them", "[gap]") {
  // A ferry whose azimuth thrusters turn within a step, by sensors whose means over it are precise.
  CHECK(step_by_usual("ferry-40m", 0.2, 0.1) < 0.6);
  // By bad sensors, or none that err, nothing is gained.
  CHECK(step_by_usual("ferry-40m", 0.2, 20.0) == Approx(1.0).margin(0.1));
  CHECK(step_by_usual("ferry-40m", 0.2, 0.0) == Approx(1.0).margin(0.1));
  CHECK(step_by_usual("vectwin-3m", 0.1, 1.0) == Approx(1.0).margin(0.1));
}
