#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "estimate/measured_hulls.hpp"
#include "ship/ship.hpp"

namespace leeway::estimate {

/// A ship's JSON from particulars: each coefficient with its source (`coefficient_sources`) and uncertainty.
struct ShipEstimate {
  io::Json json;
  Ship ship;                            ///< the same, read
  std::vector<Assumption> assumptions;  ///< what statistics filled in
  std::vector<std::string> warnings;    ///< parameters outside of a formula's range
};

/// A ship whose uncertainties are joint: the coefficients' own widths, conditioned on how well estimates as a whole
/// have met published tactical diameters (the width of kTacticalDiameter), linearly in the coefficients. Throws
/// NumericalError where the propeller cannot drive the ship at its service speed.
ShipEstimate estimate_ship(const HullParticulars& particulars, const std::vector<Width>& widths);
/// The same with each coefficient's width by itself.
ShipEstimate estimate_unconditioned(const HullParticulars& particulars, const std::vector<Width>& widths);

/// Of a turn with 35 deg of rudder, by L_pp, the geometric mean of both sides; nothing where a side does not come
/// round.
std::optional<double> tactical_diameter(const Ship& ship);

}  // namespace leeway::estimate
