#include "dynamics/maneuvers.hpp"

#include <fmt/format.h>

#include "core/errors.hpp"
#include "dynamics/straight_run.hpp"
#include "forces/registry.hpp"

namespace leeway {
namespace {

class Turning : public Maneuver {
 public:
  Turning(const Ship& ship, double rudder_rad) : ship_(ship), rudder_rad_(rudder_rad) {}
  void order(double, const ShipState<double>&, Actuators<double>& command) override {
    order_rudders(ship_, rudder_rad_, command);
  }

 private:
  const Ship& ship_;
  double rudder_rad_;
};

class Zigzag : public Maneuver {
 public:
  Zigzag(const Ship& ship, double rudder_rad, double heading_rad)
      : ship_(ship), rudder_rad_(rudder_rad), heading_rad_(heading_rad) {}
  void order(double t_s, const ShipState<double>& state, Actuators<double>& command) override {
    if (t_s == 0.0) psi_start_ = state.eta(2);
    const double change = state.eta(2) - psi_start_;
    if (rudder_rad_ > 0.0 ? change >= heading_rad_ : change <= -heading_rad_) rudder_rad_ = -rudder_rad_;
    order_rudders(ship_, rudder_rad_, command);
  }

 private:
  const Ship& ship_;
  double rudder_rad_, heading_rad_, psi_start_ = 0.0;
};

class RandomOrders : public Maneuver {
 public:
  RandomOrders(const Ship& ship, RandomStream stream) : ship_(ship), stream_(stream) {}
  void order(double t_s, const ShipState<double>&, Actuators<double>& command) override {
    if (t_s < static_cast<double>(orders_given_) * ship_.random_interval_s - 1e-9) return;
    ++orders_given_;
    for (const Actuator& actuator : ship_.actuators) {
      if (!actuator.is_random) continue;
      const double draw = stream_.normal();
      command[actuator.channel] = actuator.clip(actuator.random_mean + actuator.random_sd * draw);
    }
  }

 private:
  const Ship& ship_;
  RandomStream stream_;
  std::size_t orders_given_ = 0;
};

class Straight : public Maneuver {
 public:
  Straight(const Ship& ship, const CourseKeeper& keeper) : ship_(ship), keeper_(keeper) {}
  void order(double, const ShipState<double>& state, Actuators<double>& command) override {
    order_rudders(ship_, keeper_.rudder(state), command);
  }

 private:
  const Ship& ship_;
  CourseKeeper keeper_;
};

}  // namespace

void order_rudders(const Ship& ship, double rudder_rad, Actuators<double>& command) {
  for (const Actuator& actuator : ship.actuators)
    if (actuator.is_rudder()) command[actuator.channel] = rudder_rad;
  const auto steer = [&](const auto& thruster) {
    if constexpr (requires { thruster.steer(rudder_rad, command); }) thruster.steer(rudder_rad, command);
  };
  for (const auto& thruster : ship.modules->thrusters) std::visit(steer, thruster);
}

CourseKeeper course_keeper(const SimulatedShip& start) {
  const double u0 = start.surge_through_water();
  if (!(u0 > 0.0)) throw UsageError(fmt::format("a course is kept at a speed ahead, not at {} m/s: set --u0-mps", u0));
  return {1.0, 2.0 * start.ship.particulars.L_pp / u0, start.state.eta(2)};
}

SimulatedShip steady_ahead(const Ship& ship, double u_mps) {
  SimulatedShip start(ship, u_mps);
  ship.order_propulsion(self_propulsion_n(ship, u_mps), start.actuators);
  return start;
}

std::unique_ptr<Maneuver> straight(const Ship& ship, const CourseKeeper& keeper) {
  return std::make_unique<Straight>(ship, keeper);
}

std::unique_ptr<Maneuver> turning(const Ship& ship, double rudder_rad) {
  return std::make_unique<Turning>(ship, rudder_rad);
}

std::unique_ptr<Maneuver> zigzag(const Ship& ship, double rudder_rad, double heading_rad) {
  return std::make_unique<Zigzag>(ship, rudder_rad, heading_rad);
}

std::unique_ptr<Maneuver> random_orders(const Ship& ship, RandomStream stream) {
  return std::make_unique<RandomOrders>(ship, stream);
}

Trajectory simulate(SimulatedShip start, Maneuver& maneuver, WindProcess wind, const TimeGrid& grid,
                    Integrator integrator, Trajectory* every_step) {
  grid.check();
  const std::size_t steps_per_sample = grid.steps_per_sample(), steps = steps_per_sample * grid.samples();
  SimulatedShip& ship = start;
  Actuators<double> command = ship.actuators;
  Trajectory trajectory;
  for (std::size_t k = 0;; ++k) {
    const double t_s = grid_time(k, grid.dt_s);
    if (!ship.is_finite())
      throw NumericalError(
          fmt::format("the simulation diverged at {} s; reduce the time step (now {} s)", t_s, grid.dt_s));
    const bool is_sample = k % steps_per_sample == 0;
    if (is_sample) append_sample(trajectory, ship.ship, t_s, ship.state, {ship.actuators, wind.value(), t_s});
    if (every_step != nullptr)
      append_sample(*every_step, ship.ship, t_s, ship.state, {ship.actuators, wind.value(), t_s});
    maneuver.order(t_s, ship.state, command);
    if (k == steps || (is_sample && maneuver.is_done())) return trajectory;
    ship.step(command, wind.value(), grid.dt_s, integrator);
    wind.advance(grid.dt_s);
  }
}

}  // namespace leeway
