#include "dynamics/straight_run.hpp"

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "dynamics/simulation.hpp"
#include "forces/registry.hpp"
#include "io/files.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("straight run: thrust less its deduction balances resistance at the steady speed", "[dynamics]") {
  for (const std::string& name : io::config_names("ships")) {
    CAPTURE(name);
    const Ship ship = read_ship(name);
    const double n = 0.8 * ship.propulsion().front().initial;
    const StraightRun run = straight_run(ship, steady_speed(ship, n), n);
    CHECK(run.u > 0.0);
    CHECK(run.X_P > 0.0);
    CHECK(run.X_H < 0.0);
    CHECK_THAT(run.X_P + run.X_H + run.X_R + run.X_A, WithinAbs(0.0, 1e-12 * run.X_P));
    CHECK_THAT(self_propulsion_n(ship, run.u), WithinRel(n, 1e-12));
  }
}

TEST_CASE("straight run: KVLCC2 starts at self-propulsion, by its equations", "[dynamics]") {
  for (const char* name : {"kvlcc2-l7", "kvlcc2-full"}) {
    const Ship ship = read_ship(name);
    const double n = self_propulsion_n(ship, ship.u0_mps);
    CHECK_THAT(n, WithinAbs(ship.initial_actuators()[Channel::n_p], 5e-7));  // of the digits in the file
    // (1 - t_P) rho n^2 D^4 K_T = 0.5 rho L d U^2 R_0 by hand.
    const auto& c = std::get<StandardPropellerCoefficients<double>>(*ship.modules->propeller);
    const double u = ship.u0_mps, D = c.D_P, J = u * (1.0 - c.w_P0) / (n * D);
    const double K_T = 0.2931 - 0.2753 * J - 0.1385 * J * J;
    CHECK_THAT(0.78 * n * n * D * D * D * D * K_T,
               WithinRel(0.5 * ship.particulars.L_pp * ship.particulars.d * u * u * 0.022, 1e-12));
    const StraightRun run = straight_run(ship, u, n);
    CHECK_THAT(run.J, WithinRel(J, 1e-14));
    CHECK_THAT(run.K_T, WithinRel(K_T, 1e-13));
    CHECK_THAT(run.one_minus_w_P, WithinRel(1.0 - c.w_P0, 1e-15));
  }
}

TEST_CASE("straight run: the simulated ship settles at the steady speed, ahead and astern", "[dynamics]") {
  for (const char* name : {"kvlcc2-l7", "esso-osaka-3m"})
    for (const double n : {9.0, -9.0}) {
      CAPTURE(name, n);
      const Ship ship = read_ship(name);
      const Model<double> model(ship);
      const double u = steady_speed(ship, n);
      CHECK((u > 0.0) == (n > 0.0));
      Actuators<double> actuators;
      actuators[Channel::n_p] = n;
      double simulated = 0.0;  // held straight: a reversed screw would turn the ship
      for (int i = 0; i < 20000; ++i)
        simulated += 0.1 * model.acceleration({simulated, 0.0, 0.0}, actuators, {simulated, 0.0})(0);
      CHECK_THAT(simulated, WithinRel(u, 1e-9));
    }
}

TEST_CASE("straight run: rest needs no propeller, and what it cannot do is said", "[dynamics]") {
  const Ship ship = read_ship("vectwin-3m");
  CHECK(self_propulsion_n(ship, 0.0) == 0.0);
  CHECK(steady_speed(read_ship("kvlcc2-l7"), 0.0) == 0.0);
  CHECK_THROWS_AS(self_propulsion_n(ship, 3.0), NumericalError);
  CHECK_THROWS_AS(self_propulsion_n(ship, -0.1), NumericalError);  // Kang's propeller does not turn astern
}
