#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ship/ship.hpp"

namespace leeway {

/// A table of the shipped ships, a line each: name, L_pp, description.
std::string ship_list();

/// What a user reads to know a ship: particulars with units, force modules and actuators with their sources,
/// coefficients with what changes them and how well they are known, effects, a learned network, a straight run at the
/// initial revolutions and self-propulsion at u0.
std::string ship_report(const Ship& ship);

/// The same for programs: docs/mmg-sim.md lists the keys. Throws as ship_report().
io::Json ship_json(const Ship& ship);

/// A coefficient, or a group of them, as the ship has it, and where it lies at 95 %; of a group its factor.
struct ReportedCoefficient {
  std::string name;
  std::optional<double> value;  ///< nothing of a group
  double low = 0.0, high = 0.0;
  bool is_stated = false;    ///< whether the ship's file states the width; else it is the module's default
  bool is_absolute = false;  ///< whether the width is of the value, not of its logarithm
  std::string source;
};
std::vector<ReportedCoefficient> reported_coefficients(const Ship& ship);

/// Two coefficients that are known better together than one by one.
struct Correlation {
  std::string a, b;
  double value = 0.0;
};
/// The strongest ones first, `most` of them; none weaker than 0.1.
std::vector<Correlation> strongest_correlations(const Ship::JointUncertainty& joint, std::size_t most = 10);

}  // namespace leeway
