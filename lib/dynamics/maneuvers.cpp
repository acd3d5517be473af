#include "dynamics/maneuvers.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/errors.hpp"

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
  void order(double t_s, const ShipState<double>& state, Actuators<double>& command) override {
    if (t_s == 0.0) keeper_.course = state.eta(2);
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
}

CourseKeeper course_keeper(const Ship& ship, double u_mps) { return {1.0, 2.0 * ship.particulars.L_pp / u_mps, 0.0}; }

SimulatedShip steady_ahead(const Ship& ship, double u_mps) {
  SimulatedShip start(ship);
  start.state.nu(0) = u_mps;
  const Actuator* propeller = ship.find_actuator(Channel::n_p);
  const auto surge = [&](double n) {
    start.actuators[Channel::n_p] = n;
    return start.model.acceleration(start.state.nu, start.actuators, Vec2<double>(u_mps, 0.0))(0);
  };
  double low = std::max(0.0, propeller->min), high = propeller->max;
  if (!(surge(low) <= 0.0) || !(surge(high) >= 0.0))
    throw UsageError(
        fmt::format("the ship '{}' cannot hold {} m/s: no revolutions from {} to {} 1/s balance the resistance",
                    ship.name, u_mps, low, high));
  for (int i = 0; i < 100 && low < high; ++i) {
    const double middle = 0.5 * (low + high);
    (surge(middle) < 0.0 ? low : high) = middle;
  }
  start.actuators[Channel::n_p] = high;
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
  const std::size_t steps = grid.steps_per_sample() * grid.samples();
  SimulatedShip& ship = start;
  Actuators<double> command = ship.actuators;
  Trajectory trajectory;
  for (std::size_t k = 0;; ++k) {
    const double t_s = grid_time(k, grid.dt_s);
    if (!ship.is_finite())
      throw NumericalError(
          fmt::format("the simulation diverged at {} s; reduce the time step (now {} s)", t_s, grid.dt_s));
    const bool is_sample = k % grid.steps_per_sample() == 0;
    const Inputs<double> inputs{ship.actuators, wind.value()};
    if (is_sample) append_sample(trajectory, ship.ship, t_s, ship.state, inputs);
    if (every_step != nullptr) append_sample(*every_step, ship.ship, t_s, ship.state, inputs);
    maneuver.order(t_s, ship.state, command);
    if (k == steps || (is_sample && maneuver.is_done())) return trajectory;
    ship.step(command, wind.value(), grid.dt_s, integrator);
    wind.advance(grid.dt_s);
  }
}

}  // namespace leeway
