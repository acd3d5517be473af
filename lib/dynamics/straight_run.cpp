#include "dynamics/straight_run.hpp"

#include <cmath>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/model.hpp"

namespace leeway {
namespace {

Actuators<double> with_revolutions(const Ship& ship, double n) {
  Actuators<double> actuators;
  ship.order_propulsion(n, actuators);
  return actuators;
}

// du/dt of the constrained ship; in calm air the apparent wind is the ship's own speed.
double surge_acceleration(const Ship& ship, const Model<double>& model, double u, double n) {
  return model.acceleration({u, 0.0, 0.0}, with_revolutions(ship, n), {u, 0.0})(0);
}

// Where f changes sign between a and b, to the last bits of a double.
template <typename Function>
double bisect(const Function& f, double a, double b) {
  const bool is_positive_at_a = f(a) > 0.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (a + b);
    if (middle == a || middle == b) break;
    ((f(middle) > 0.0) == is_positive_at_a ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

}  // namespace

StraightRun straight_run(const Ship& ship, double u, double n) {
  const Model<double> model(ship);
  const ModuleForces<double> forces = model.forces({u, 0.0, 0.0}, with_revolutions(ship, n), {u, 0.0});
  const PropellerFlow<double>& flow = forces.propeller;
  StraightRun run{u, n};
  run.X_P = flow.force(0) + forces.thrusters(0);
  run.X_H = forces.hull(0);
  run.X_R = forces.rudder(0);
  run.X_A = forces.wind(0);
  run.one_minus_w_P = flow.one_minus_w_P;
  if (flow.n != 0.0) {
    run.J = flow.J;
    run.K_T = flow.n2_K_T / (flow.n * flow.n);
  }
  return run;
}

double self_propulsion_n(const Ship& ship, double u) {
  if (u == 0.0) return 0.0;
  const Model<double> model(ship);
  const Actuator propeller = ship.propulsion().front();
  const double most = u > 0.0 ? propeller.max : propeller.min;
  const auto excess = [&](double n) { return (u > 0.0 ? 1.0 : -1.0) * surge_acceleration(ship, model, u, n); };
  if (!(excess(0.0) < 0.0) || !(excess(most) > 0.0))
    throw NumericalError(
        fmt::format("the ship '{}' cannot hold {} m/s on a straight run: its propeller is limited to {} .. {} 1/s",
                    ship.name, u, propeller.min, propeller.max));
  return bisect(excess, 0.0, most);
}

double steady_speed(const Ship& ship, double n) {
  const Model<double> model(ship);
  const auto acceleration = [&](double u) { return surge_acceleration(ship, model, u, n); };
  const double at_rest = acceleration(0.0);
  if (at_rest == 0.0) return 0.0;
  const double speed_of_Fr_1 = std::sqrt(kGravity_mps2 * ship.particulars.L_pp);
  const double step = std::copysign(0.02 * speed_of_Fr_1, at_rest);
  double u = step;
  for (; (acceleration(u) > 0.0) == (at_rest > 0.0); u += step)
    if (std::abs(u) > 2.0 * speed_of_Fr_1)
      throw NumericalError(fmt::format("the ship '{}' finds no steady speed at {} 1/s", ship.name, n));
  return bisect(acceleration, u - step, u);
}

}  // namespace leeway
