#include <cmath>

#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "dynamics/simulation.hpp"
#include "forces/registry.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("Froude scaling: vectwin-150m sails the track of vectwin-3m, times 50, in times sqrt(50)", "[dynamics]") {
  const Ship model = read_ship("vectwin-3m");
  Ship full = read_ship("vectwin-150m");
  // The ratio of the densities of air and water is what does not scale: give the ship the model's.
  std::get<FujiwaraWindGeometry>(*full.modules->wind).rho_air *= full.particulars.rho / model.particulars.rho;
  const double k = model.scale, root_k = std::sqrt(k);
  CHECK(k == full.particulars.L_pp / model.particulars.L_pp);

  SimulatedShip small(model), large(full);
  const Vec2<double> wind(0.9, -0.7);
  double distance = 0.0;
  for (int i = 0; i < 1200; ++i) {
    // Rudders to both extremes, the thruster both ways: every branch on the way is crossed by both.
    Actuators<double> command = small.actuators;
    command[Channel::delta_p] = (i / 300 % 2 == 0 ? 25.0 : -105.0) * kDegree;
    command[Channel::delta_s] = (i / 300 % 2 == 0 ? 30.0 : 105.0) * kDegree;
    command[Channel::n_p] = 11.0;
    command[Channel::n_bt] = i / 200 % 2 == 0 ? 22.0 : -13.0;
    small.step(command, wind, 0.1);
    command[Channel::n_p] /= root_k;
    command[Channel::n_bt] /= root_k;
    large.step(command, root_k * wind, 0.1 * root_k);
    distance = std::max(distance, (large.state.eta.head<2>() / k - small.state.eta.head<2>()).norm());
  }
  CHECK(small.state.eta.head<2>().norm() > 2.0);
  CHECK(distance < 1e-8);  // m, of the 12 digits in the JSON, by the steps of the model where they are crossed
  CHECK_THAT(large.state.eta(2), WithinAbs(small.state.eta(2), 1e-8));
  CHECK_THAT(large.state.nu(0) / root_k, WithinAbs(small.state.nu(0), 1e-8));
  CHECK_THAT(large.state.nu(2) * root_k, WithinAbs(small.state.nu(2), 1e-8));
  for (const Channel rudder : {Channel::delta_p, Channel::delta_s})
    CHECK_THAT(large.actuators[rudder], WithinAbs(small.actuators[rudder], 1e-10));
}
