#include <filesystem>
#include <vector>

#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "dynamics/maneuvers.hpp"
#include "io/trajectory_csv.hpp"

using namespace leeway;

namespace {

struct Differences {
  double position = 0.0, psi = 0.0, velocity = 0.0, r = 0.0, delta = 0.0;  // largest, SI
};

Differences largest_differences(const Trajectory& a, const Trajectory& b) {
  Differences largest;
  const auto update = [](double& value, double difference) { value = std::max(value, std::abs(difference)); };
  for (std::size_t i = 0; i < a.size(); ++i) {
    update(largest.position, std::hypot(a[Channel::x0][i] - b[Channel::x0][i], a[Channel::y0][i] - b[Channel::y0][i]));
    update(largest.psi, a[Channel::psi][i] - b[Channel::psi][i]);
    update(largest.velocity, std::hypot(a[Channel::u][i] - b[Channel::u][i], a[Channel::vm][i] - b[Channel::vm][i]));
    update(largest.r, a[Channel::r][i] - b[Channel::r][i]);
    update(largest.delta, a[Channel::delta][i] - b[Channel::delta][i]);
  }
  return largest;
}

}  // namespace

// The reference was made with RK4 at 0.02 s, a pure rate limit on the rudder and, in the zigzag, the heading looked at
// on that grid; its rows come every 0.5 s. The files hold 7 decimals (m, deg), and that is how far the two agree.
TEST_CASE("kvlcc2-l7: turning circle and zigzag agree with an independent implementation", "[published]") {
  const Ship ship = read_ship("kvlcc2-l7");
  const double L = ship.particulars.L_pp;
  for (const bool is_zigzag : {false, true}) {
    const std::string name = is_zigzag ? "kvlcc2-l7-zigzag-20-20-starboard" : "kvlcc2-l7-turning-35";
    const std::string path = LEEWAY_SHARED_FOLDER "/reference/" + name + ".csv";
    if (!std::filesystem::exists(path)) {
      WARN("SKIPPED: no " << path);
      return;
    }
    CAPTURE(name);
    const Trajectory reference = io::read_trajectory(path);
    const auto maneuver = is_zigzag ? zigzag(ship, 20.0 * kDegree, 20.0 * kDegree) : turning(ship, 35.0 * kDegree);
    const Trajectory run = simulate(SimulatedShip(ship), *maneuver, {}, {0.02, 0.5, reference[Channel::t].back()});
    REQUIRE(run.size() == reference.size());
    const Differences d = largest_differences(run, reference);
    CHECK(d.position < 1e-4 * L);
    CHECK(d.psi < 1e-4);
    CHECK(d.velocity < 1e-4 * ship.u0_mps);
    CHECK(d.r < 1e-4 * ship.u0_mps / L);
    CHECK(d.delta < 1e-6);
  }
}
