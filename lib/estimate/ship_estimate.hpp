#pragma once

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

/// Throws NumericalError where the propeller cannot drive the ship at its service speed.
ShipEstimate estimate_ship(const HullParticulars& particulars, const std::vector<Width>& widths);

}  // namespace leeway::estimate
