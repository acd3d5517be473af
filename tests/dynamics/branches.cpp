#include <algorithm>
#include <cmath>
#include <functional>

#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "dynamics/model.hpp"
#include "dynamics/model_parts.hpp"
#include "forces/force_modules.hpp"
#include "io/files.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;

// Every shipped ship as a whole, on and around the branches of its modules.

namespace {

// A state by nondimensional numbers, so that one list serves ships of 3 m and 320 m: velocities by u0, yaw rate by
// u0/L, revolutions by the initial ones.
struct State {
  double u, v, r, n, delta_deg;
};

struct OperatingPoint {
  Vec3<double> nu;
  Actuators<double> actuators;
};

OperatingPoint point_of(const Ship& ship, const State& s) {
  const double U = ship.u0_mps;
  OperatingPoint point{{s.u * U, s.v * U, s.r * U / ship.particulars.L_pp}, {}};
  for (const Actuator& a : ship.actuators) {
    if (a.is_rudder() || a.turns_freely()) point.actuators[a.channel] = s.delta_deg * kDegree;
    if (a.is_propulsion()) point.actuators[a.channel] = s.n * a.initial;
    if (a.channel == Channel::n_bt) point.actuators[a.channel] = 0.4 * a.max;
  }
  return point;
}

Vec3<double> force(const Ship& ship, const State& s) {
  const OperatingPoint point = point_of(ship, s);
  return ForceModules<double>(*ship.modules, ship.particulars)
      .force(point.nu, point.actuators, {0.3 * ship.u0_mps, -0.6 * ship.u0_mps});
}

// (X, Y, N/L) by 0.5 rho L d u0^2.
Vec3<double> nondimensional(const Ship& ship, const Vec3<double>& f) {
  const Particulars& p = ship.particulars;
  return Vec3<double>(f(0), f(1), f(2) / p.L_pp) / (0.5 * p.rho * p.L_pp * p.d * ship.u0_mps * ship.u0_mps);
}

// The largest step of the forces along a line of states, state(x) for x from a to b: the intervals with the largest
// differences are halved until nothing but a step is left in them.
template <typename Line>
double largest_step(const Ship& ship, const Line& state, double a, double b) {
  const ForceModules<double> modules(*ship.modules, ship.particulars);
  const auto at = [&](double x) {
    const OperatingPoint point = point_of(ship, state(x));
    return nondimensional(ship, modules.force(point.nu, point.actuators, Vec2<double>::Zero()));
  };
  const auto change = [&](double x, double y) { return (at(x) - at(y)).cwiseAbs().maxCoeff(); };
  constexpr int kIntervals = 3000;
  std::vector<std::pair<double, double>> found;  // change, left end
  const double h = (b - a) / kIntervals;
  for (int i = 0; i < kIntervals; ++i) found.emplace_back(change(a + i * h, a + (i + 1) * h), a + i * h);
  std::partial_sort(found.begin(), found.begin() + 12, found.end(), std::greater<>());
  double largest = 0.0;
  for (int i = 0; i < 12; ++i) {
    double left = found[static_cast<std::size_t>(i)].second, width = h;
    while (width > 1e-11 * (b - a)) {
      width /= 2.0;
      if (change(left, left + width) < change(left + width, left + 2.0 * width)) left += width;
    }
    largest = std::max(largest, change(left, left + width));
  }
  return largest;
}

}  // namespace

TEST_CASE("branches: every ship has finite forces and accelerations in any motion", "[dynamics]") {
  for (const std::string& name : io::config_names("ships")) {
    const Ship ship = read_ship(name);
    const Model<double> model(ship);
    double largest = 0.0;
    for (const double u : {-1.0, -1e-9, 0.0, 1e-9, 1.1})
      for (const double v : {-0.6, -1e-9, 0.0, 1e-9, 0.6})
        for (const double r : {-1.5, -1e-9, 0.0, 0.8})
          for (const double n : {-1.3, -1e-9, 0.0, 1e-9, 1.0})
            for (const double delta : {-105.0, -37.5, 0.0, 35.0, 105.0}) {
              CAPTURE(name, u, v, r, n, delta);
              const State state{u, v, r, n, delta};
              const OperatingPoint point = point_of(ship, state);
              REQUIRE(model.acceleration(point.nu, point.actuators, {0.0, 0.0}).allFinite());
              largest = std::max(largest, nondimensional(ship, force(ship, state)).cwiseAbs().maxCoeff());
            }
    CAPTURE(name);
    CHECK(largest < 10.0);  // nothing blows up where speed or revolutions vanish
  }
}

TEST_CASE("branches: twice the speeds and revolutions give four times the force", "[dynamics]") {
  for (const std::string& name : io::config_names("ships")) {
    Ship ship = read_ship(name);
    ship.modules->thrusters.clear();  // their force depends on the Froude number
    const ForceModules<double> modules(*ship.modules, ship.particulars);
    for (const State& state :
         {State{0.9, 0.1, 0.3, 1.0, 20.0}, State{0.4, -0.5, -0.6, 0.7, -35.0}, State{-0.5, 0.2, 0.2, 1.1, 105.0},
          State{0.6, 0.02, 0.1, -1.0, -105.0}, State{-0.6, -0.02, 0.5, -0.8, 10.0}, State{0.0, 0.0, 0.0, 1.0, 30.0},
          State{0.0, 0.3, 0.0, 0.0, 30.0}, State{0.0, 0.0, 0.9, 0.0, 0.0}}) {
      const OperatingPoint point = point_of(ship, state);
      Actuators<double> twice = point.actuators;
      twice[Channel::n_p] *= 2.0;
      const Vec2<double> wind(0.3, -0.2);
      const Vec3<double> once = modules.force(point.nu, point.actuators, wind);
      const Vec3<double> four = modules.force(2.0 * point.nu, twice, 2.0 * wind);
      CAPTURE(name, state.u, state.n);
      CHECK((four - 4.0 * once).norm() <= 1e-12 * (four.norm() + 1e-9));
    }
  }
}

TEST_CASE("branches: forces of vectwin-150m are those of vectwin-3m by Froude's law", "[dynamics]") {
  Ship model = read_ship("vectwin-3m"), full = read_ship("vectwin-150m");
  model.modules->wind.reset();
  full.modules->wind.reset();
  const double k = model.scale, rho = full.particulars.rho / model.particulars.rho;
  for (const State& state : {State{0.9, 0.1, 0.3, 1.0, 20.0}, State{0.4, -0.5, -0.6, 0.7, -35.0},
                             State{-0.5, 0.2, 0.2, 1.1, 80.0}, State{0.2, -0.02, 0.5, 0.8, -100.0}}) {
    const Vec3<double> small = force(model, state), large = force(full, state);
    CAPTURE(state.u, state.delta_deg);
    for (int i = 0; i < 3; ++i)
      CHECK_THAT(large(i) / (rho * k * k * k * (i == 2 ? k : 1.0)), WithinAbs(small(i), 1e-9 * small.norm()));
  }
}

TEST_CASE("branches: along lines through them forces are continuous, or step as their model does", "[dynamics]") {
  const auto drift = [](double n) {
    return [n](double beta) { return State{0.8 * std::cos(beta), -0.8 * std::sin(beta), 0.3, n, 25.0}; };
  };
  const auto through_rest = [](double x) { return State{x, 0.4 * x, 2.0 * x, 0.9, 25.0}; };
  const auto on_the_spot = [](double r) { return State{0.0, 0.0, r, 0.9, 25.0}; };
  const auto revolutions = [](double u) { return [u](double n) { return State{u, 0.1, 0.3, n, 25.0}; }; };
  const auto rudder = [](double u) { return [u](double delta) { return State{u, 0.1, 0.3, 0.9, delta}; }; };

  // Largest steps, by 0.5 rho L d u0^2. esso-osaka-3m: the thruster's cut-off speed (drift); side force of a propeller
  // that backs a ship, from u = 0 on (rest); two fits that meet at n = 0, and the slipstream that ends where K_T does,
  // going astern by giving way at once to a flow from astern (n). vectwin: wake and deduction at u = 0 (rest); l_R with
  // the sign of r (on the spot); the slipstream that ends where K_T does (n); flow straightening at the neutral angle
  // and C_N at 37.5 deg (delta). kvlcc2 steps only in the borrowed law of the reversed propeller, at J_s = -0.233 (n
  // slow).
  struct Steps {
    const char* ship;
    double drift, drift_reversed, rest, on_the_spot, n_ahead, n_slow, n_astern, delta_ahead, delta_astern;
  };
  for (const Steps& stated :
       {Steps{"esso-osaka-3m", 0.004925, 0.004925, 0.0016732, 0.0, 0.002019, 0.00020053, 0.032275, 0.0, 0.0},
        Steps{"kvlcc2-l7", 0.0, 0.0, 0.0, 0.0, 0.0, 0.000042727, 0.0, 0.0, 0.0},
        Steps{"kvlcc2-full", 0.0, 0.0, 0.0, 0.0, 0.0, 0.000043079, 0.0, 0.0, 0.0},
        Steps{"vectwin-3m", 0.0, 0.0, 0.00073198, 0.00019626, 0.013679, 0.0023126, 0.0, 0.0019682, 0.0011703},
        Steps{"vectwin-150m", 0.0, 0.0, 0.00073198, 0.00019626, 0.013679, 0.0023126, 0.0, 0.0019682, 0.0011703}}) {
    const Ship ship = read_ship(stated.ship);
    const auto check = [&](const char* line, double step, double expected) {
      CAPTURE(stated.ship, line, step);
      // 1e-7 for the roots of small flows, which are continuous but steep.
      CHECK_THAT(step, WithinAbs(expected, 0.01 * expected + 1e-7));
    };
    check("drift", largest_step(ship, drift(0.9), -kPi - 0.1, kPi + 0.1), stated.drift);
    check("drift, n < 0", largest_step(ship, drift(-0.8), -kPi - 0.1, kPi + 0.1), stated.drift_reversed);
    check("rest", largest_step(ship, through_rest, -0.3, 0.31), stated.rest);
    check("on the spot", largest_step(ship, on_the_spot, -1.0, 1.03), stated.on_the_spot);
    check("n ahead", largest_step(ship, revolutions(0.8), -1.2, 1.23), stated.n_ahead);
    check("n slow", largest_step(ship, revolutions(0.3), -1.2, 1.23), stated.n_slow);
    check("n astern", largest_step(ship, revolutions(-0.8), -1.2, 1.23), stated.n_astern);
    check("delta ahead", largest_step(ship, rudder(0.8), -105.0, 106.0), stated.delta_ahead);
    check("delta astern", largest_step(ship, rudder(-0.5), -105.0, 106.0), stated.delta_astern);
  }
}
