#include "dynamics/maneuvers.hpp"

#include <fmt/format.h>

#include "core/errors.hpp"

namespace leeway {
namespace {

void order_rudders(const Ship& ship, double rudder_rad, Actuators<double>& command) {
  for (const Actuator& actuator : ship.actuators)
    if (actuator.is_rudder()) command[actuator.channel] = rudder_rad;
}

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

}  // namespace

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
                    Integrator integrator) {
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
    if (k % grid.steps_per_sample() == 0)
      append_sample(trajectory, ship.ship, t_s, ship.state, {ship.actuators, wind.value()});
    if (k == steps) return trajectory;
    maneuver.order(t_s, ship.state, command);
    ship.step(command, wind.value(), grid.dt_s, integrator);
    wind.advance(grid.dt_s);
  }
}

}  // namespace leeway
