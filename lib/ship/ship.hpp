#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ship/actuators.hpp"
#include "ship/coefficients.hpp"

namespace leeway {

/// A ship as its JSON describes it: complete and checked. SI and radians.
struct Ship {
  std::string name, file;
  Particulars particulars;
  InertiaCoefficients<double> inertia;
  HullCoefficients hull;
  PropellerCoefficients propeller;
  RudderCoefficients rudder;
  std::vector<ThrusterCoefficients> thrusters;
  std::optional<WindCoefficients> wind;
  std::vector<Actuator> actuators;  ///< every channel that a module reads, each once
  double u0_mps = 0.0;              ///< surge at which maneuvers start unless told otherwise
  double random_interval_s = 0.0;   ///< time between random orders

  /// Nothing where the ship has no such actuator.
  const Actuator* find_actuator(Channel channel) const;
  std::vector<Channel> actuator_channels() const;
  Actuators<double> initial_actuators() const;
};

/// Reads a ship ("-": standard input): a path, or the name of a shipped one such as "vectwin-3m". docs/mmg-sim.md
/// describes the keys. Throws InputError for an unknown, missing or impossible value, for a module without its
/// actuator, and for an actuator that no module reads; UsageError for a name that is not shipped.
Ship read_ship(const std::string& name_or_path);

}  // namespace leeway
