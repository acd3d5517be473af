#pragma once

#include "core/random.hpp"
#include "core/units.hpp"
#include "dynamics/simulation.hpp"

namespace leeway::test {

/// A run of a ship under random actuators that are held for a second each, and a steady wind, sampled at 1 s: a replay
/// that holds its inputs differs from it by the time step alone.
///   noise  standard deviation of u, v_m [m/s]; a tenth of it in rad/s for r
inline Trajectory simulated_recording(const Ship& ship, std::uint64_t seed, std::size_t points, double noise = 0.0) {
  RandomStream random(seed, "simulated recording");
  Trajectory t;
  t.name = "simulated-" + std::to_string(seed);
  t.file = t.name + ".csv";
  SimulatedShip simulated(ship);
  simulated.state.eta(2) = random.uniform(-3.0, 3.0);
  simulated.state.nu(0) = random.uniform(0.3, 0.5);
  const double speed = random.uniform(0.5, 1.0), direction = random.uniform(0.0, 6.0);
  Inputs<double> held{ship.initial_actuators(), wind_from_vector(speed, direction), 0.0};
  for (std::size_t k = 0; k < points; ++k) {
    if (k % 15 == 0)
      for (const Actuator& actuator : ship.actuators) {
        const double order = random.normal();
        if (actuator.is_random)
          held.actuators[actuator.channel] = actuator.clip(actuator.random_mean + actuator.random_sd * order);
      }
    append_sample(t, ship, static_cast<double>(k), simulated.state, held);
    for (int i = 0; i < 10; ++i) simulated.advance({held, held, held}, 0.1);
  }
  for (std::size_t k = 0; k < points; ++k) {
    t[Channel::u][k] += noise * random.normal();
    t[Channel::vm][k] += noise * random.normal();
    t[Channel::r][k] += 0.1 * noise * random.normal();
  }
  return t;
}

}  // namespace leeway::test
