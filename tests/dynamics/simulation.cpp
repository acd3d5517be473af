#include "dynamics/simulation.hpp"

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/maneuvers.hpp"
#include "forces/registry.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

ShipState<double> run(const Model<double>& model, ShipState<double> state, const Inputs<double>& inputs, double dt_s,
                      double duration_s, Integrator integrator) {
  const auto steps = static_cast<int>(std::lround(duration_s / dt_s));
  for (int i = 0; i < steps; ++i) state = integrate(model, state, {inputs, inputs, inputs}, dt_s, integrator);
  return state;
}

}  // namespace

TEST_CASE("simulation: a single screw ship with equal sides sails to port as to starboard", "[dynamics]") {
  // The difference of the sides is in gamma_R, in the wake and, reversed or astern, in the side force of the propeller.
  Ship tanker = read_ship("kvlcc2-l7"), esso = read_ship("esso-osaka-3m");
  auto& wake = std::get<StandardPropellerCoefficients<double>>(*tanker.modules->propeller);
  wake.C_2_positive = wake.C_2_negative;
  auto& standard = std::get<StandardRudderCoefficients<double>>(*tanker.modules->rudder);
  standard.gamma_R_positive = standard.gamma_R_negative;
  auto& single = std::get<SingleRudderCoefficients<double>>(*esso.modules->rudder);
  single.gamma_R_positive = single.gamma_R_negative;
  for (const Ship* ship : {&tanker, &esso}) {
    const auto run_to = [&](double side) {
      const auto maneuver = zigzag(*ship, side * 20.0 * kDegree, 15.0 * kDegree);
      return simulate(SimulatedShip(*ship), *maneuver, wind_from_vector(0.8, 0.0), {0.1, 1.0, 150.0});  // from ahead
    };
    const Trajectory starboard = run_to(1.0), port = run_to(-1.0);
    for (std::size_t i = 0; i < port.size(); ++i) {
      CHECK_THAT(port[Channel::x0][i], WithinAbs(starboard[Channel::x0][i], 1e-9));
      CHECK_THAT(port[Channel::y0][i], WithinAbs(-starboard[Channel::y0][i], 1e-9));
      CHECK_THAT(port[Channel::r][i], WithinAbs(-starboard[Channel::r][i], 1e-10));
    }
  }
}

TEST_CASE("integrators: halving the step shrinks the error by 2^4 (RK4) and 2 (Euler)", "[dynamics]") {
  // A turn that crosses no branch, so that the order of the method shows.
  const Ship ship = read_ship(GENERATE("esso-osaka-3m", "kvlcc2-l7"));
  const Model<double> model(ship);
  Inputs<double> inputs;
  inputs.actuators[Channel::delta] = 10.0 * kDegree;
  inputs.actuators[Channel::n_p] = 12.0;
  ShipState<double> start;
  start.nu = {0.45, -0.05, 0.06};
  const auto error = [&](double dt_s, Integrator integrator) {
    const ShipState<double> exact = run(model, start, inputs, 0.02, 8.0, Integrator::rk4);
    const ShipState<double> result = run(model, start, inputs, dt_s, 8.0, integrator);
    return (result.eta - exact.eta).norm() + (result.nu - exact.nu).norm();
  };
  CHECK_THAT(error(0.8, Integrator::rk4) / error(0.4, Integrator::rk4), WithinAbs(16.0, 4.0));
  CHECK_THAT(error(0.2, Integrator::euler) / error(0.1, Integrator::euler), WithinAbs(2.0, 0.1));
}

TEST_CASE("simulation: turning the start and the wind turns the track and nothing else", "[dynamics]") {
  const Ship ship = read_ship("vectwin-3m");
  const double turn = 0.8;
  const auto final_state = [&](double psi, double wind_dir) {
    SimulatedShip simulated(ship);
    simulated.state.eta(2) = psi;
    const auto maneuver = turning(ship, 25.0 * kDegree);
    return simulate(simulated, *maneuver, wind_from_vector(1.2, wind_dir), {0.1, 1.0, 60.0});
  };
  const Trajectory a = final_state(0.0, 0.5), b = final_state(turn, 0.5 + turn);
  const auto last = [](const Trajectory& t, Channel c) { return t[c].back(); };
  for (const Channel c : {Channel::u, Channel::vm, Channel::r}) CHECK_THAT(last(b, c), WithinAbs(last(a, c), 1e-11));
  const double x = last(a, Channel::x0), y = last(a, Channel::y0);
  CHECK_THAT(last(b, Channel::x0), WithinAbs(x * std::cos(turn) - y * std::sin(turn), 1e-9));
  CHECK_THAT(last(b, Channel::y0), WithinAbs(x * std::sin(turn) + y * std::cos(turn), 1e-9));
}

TEST_CASE("simulation: a straight run settles where thrust balances resistance", "[dynamics]") {
  Ship ship = read_ship("esso-osaka-3m");
  ship.modules->wind.reset();  // so that no air resistance enters
  SimulatedShip simulated(ship);
  // Held straight by symmetry: no sway, no yaw.
  for (int i = 0; i < 15000; ++i) simulated.step(simulated.actuators, {0.0, 0.0}, 0.1);
  CHECK(simulated.state.nu(1) == 0.0);
  CHECK(simulated.state.nu(2) == 0.0);
  const double u = simulated.state.nu(0), D = 0.084, n = 10.0, w = 0.386 * u / D;
  const double thrust = 0.78 * 998.0 * std::pow(D, 4) * (0.3278 * n * n - 0.3323 * n * w - 0.156 * w * w);
  CHECK_THAT(thrust, WithinRel(0.5 * 998.0 * 3.0 * 0.20114 * 0.02139 * u * u, 1e-9));
}

TEST_CASE("simulation: a steady turn has zero acceleration", "[dynamics]") {
  const Ship ship = read_ship("vectwin-3m");
  SimulatedShip simulated(ship);
  Actuators<double> command = simulated.actuators;
  command[Channel::delta_p] = command[Channel::delta_s] = 35.0 * kDegree;
  for (int i = 0; i < 6000; ++i) simulated.step(command, {0.0, 0.0}, 0.1);
  const Vec3<double>& nu = simulated.state.nu;
  const Vec3<double> rate = simulated.model.acceleration(nu, simulated.actuators, nu.head<2>());
  CHECK(rate.norm() < 1e-9);
  CHECK(nu(2) > 0.0);
}

TEST_CASE("simulation: in a steady turn the track is a circle of radius U/r", "[dynamics]") {
  const Ship ship = read_ship("kvlcc2-l7");
  for (const double rudder : {-35.0, 20.0}) {
    const auto maneuver = turning(ship, rudder * kDegree);
    const Trajectory t = simulate(SimulatedShip(ship), *maneuver, {}, {0.1, 5.0, 800.0});
    const auto point = [&](std::size_t back) {
      const std::size_t i = t.size() - 1 - back;
      return Vec2<double>(t[Channel::x0][i], t[Channel::y0][i]);
    };
    // The circle through three points of the track.
    const Vec2<double> a = point(0), b = point(8), c = point(16);
    const double area = 0.5 * std::abs((b - a)(0) * (c - a)(1) - (b - a)(1) * (c - a)(0));
    const double radius = (a - b).norm() * (b - c).norm() * (c - a).norm() / (4.0 * area);
    const double U = std::hypot(t[Channel::u].back(), t[Channel::vm].back());
    CAPTURE(rudder);
    CHECK_THAT(radius, WithinRel(U / std::abs(t[Channel::r].back()), 1e-6));
    CHECK(t[Channel::r].back() * rudder > 0.0);
  }
}

TEST_CASE("actuators: the response is the exact solution, whatever the step", "[dynamics]") {
  Actuator actuator;
  actuator.min = -0.5;
  actuator.max = 1.0;
  actuator.rate = 0.35;
  actuator.time_constant_s = 0.1;
  const double one = respond(actuator, -0.2, 0.6, 3.0);
  double many = -0.2;
  for (int i = 0; i < 300; ++i) many = respond(actuator, many, 0.6, 0.01);
  CHECK_THAT(many, WithinAbs(one, 1e-13));
  CHECK_THAT(respond(actuator, -0.2, 0.6, 1.0), WithinAbs(-0.2 + 0.35, 1e-15));                  // ramp
  CHECK_THAT(respond(actuator, 0.0, 2.0, 1e3), WithinAbs(1.0, 1e-15));                           // upper limit
  CHECK_THAT(respond(actuator, 0.0, -2.0, 1e3), WithinAbs(-0.5, 1e-15));                         // lower limit
  CHECK_THAT(respond(actuator, 0.0, 0.02, 0.1), WithinRel(0.02 * (1 - std::exp(-1.0)), 1e-12));  // no ramp
  actuator.time_constant_s = 0.0;
  CHECK(respond(actuator, 0.0, 0.1, 1.0) == 0.1);
  CHECK_THAT(respond(actuator, 0.0, -0.4, 1.0), WithinAbs(-0.35, 1e-15));
}

TEST_CASE("actuators: one command beyond both limits stops each rudder at its own", "[dynamics]") {
  const Ship ship = read_ship("vectwin-3m");
  SimulatedShip simulated(ship);
  Actuators<double> command = simulated.actuators;
  command[Channel::delta_p] = command[Channel::delta_s] = -60.0 * kDegree;
  for (int i = 0; i < 100; ++i) simulated.step(command, {0.0, 0.0}, 0.1);
  CHECK_THAT(simulated.actuators[Channel::delta_p], WithinAbs(-60.0 * kDegree, 1e-9));
  CHECK_THAT(simulated.actuators[Channel::delta_s], WithinAbs(-35.0 * kDegree, 1e-9));
}

TEST_CASE("zigzag: the rudder goes over when the heading has changed by the set angle", "[dynamics]") {
  const Ship ship = read_ship("esso-osaka-3m");
  for (const double side : {-1.0, 1.0}) {
    const auto maneuver = zigzag(ship, side * 10.0 * kDegree, 10.0 * kDegree);
    const Trajectory t = simulate(SimulatedShip(ship), *maneuver, {}, {0.1, 0.1, 150.0});
    CHECK_THAT(t[Channel::delta][10] / kDegree, WithinAbs(side * 10.0, 0.1));
    std::size_t turns = 0;
    for (std::size_t i = 1; i < t.size(); ++i)
      if ((t[Channel::delta][i] > 0.0) != (t[Channel::delta][i - 1] > 0.0) && i > 1) {
        ++turns;
        CHECK(std::abs(t[Channel::psi][i]) > 10.0 * kDegree);
      }
    CHECK(turns >= 2);
  }
}

TEST_CASE("random orders: they follow the seed, stay within limits and come every 20 s", "[dynamics]") {
  const Ship ship = read_ship("vectwin-3m");
  const auto once = [&](std::uint64_t seed) {
    const auto maneuver = random_orders(ship, {seed, "random orders"});
    return simulate(SimulatedShip(ship), *maneuver, {}, {0.1, 1.0, 200.0});
  };
  const Trajectory a = once(3), b = once(3), c = once(4);
  CHECK(a[Channel::delta_p] == b[Channel::delta_p]);
  CHECK(a[Channel::delta_p] != c[Channel::delta_p]);
  for (const Actuator& actuator : ship.actuators)
    for (const double value : a[actuator.channel]) CHECK(actuator.clip(value) == value);
  // 20 s are enough for every order to be reached: the value stands before each new order.
  for (std::size_t k = 1; k < 10; ++k)
    CHECK_THAT(a[Channel::n_bt][20 * k], WithinAbs(a[Channel::n_bt][20 * k - 8], 1e-9));
}

TEST_CASE("simulation: times that do not divide and divergence are refused", "[dynamics]") {
  CHECK_THROWS_AS((TimeGrid{0.3, 1.0, 10.0}.check()), UsageError);
  CHECK_THROWS_AS((TimeGrid{0.1, 1.0, 10.5}.check()), UsageError);
  CHECK_NOTHROW((TimeGrid{0.02, 0.5, 10.0}.check()));
  CHECK(grid_time(3, 0.1) == 0.3);
  const Ship ship = read_ship("vectwin-3m");
  const auto maneuver = turning(ship, 0.5);
  CHECK_THROWS_AS(simulate(SimulatedShip(ship), *maneuver, {}, {100.0, 100.0, 10000.0}), NumericalError);
}
