#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/maneuvers.hpp"
#include "io/json.hpp"

namespace leeway {

/// What was done, as far as indices and criteria depend on it.
struct ManeuverFacts {
  std::string maneuver;                ///< "turning", "zigzag", ...: the subcommand
  double rudder = 0.0, heading = 0.0;  ///< of a berthing: the heading of the quay
  std::vector<Phase> phases;
  double mean_wind_mps = 0.0;
};

/// The criteria of IMO resolution MSC.137(76), Standards for ship manoeuvrability, that this maneuver is the test for:
/// each with value, limit and whether it is fulfilled (null where the run did not reach it), or the reason why none
/// applies. Length and speed are those of the full-scale ship.
///   indices  of the maneuver, by dynamics/indices.hpp;  speed_mps  at the start, of the ship as simulated
io::Json imo_criteria(const io::Json& indices, const ManeuverFacts& facts, const Ship& ship, double speed_mps);

/// A recorded test, of which no model is known.
struct RecordedTest {
  double L_pp_m = 0.0;         ///< of the full-scale ship
  double speed_mps = 0.0;      ///< at the order, full scale
  double hardest_rudder;       ///< the ship's largest rudder angle, 35 deg at most [rad]
  double mean_wind_mps = 0.0;  ///< full scale
};

/// The same for a recording, which no wind is without: up to Beaufort 5, as IMO MSC/Circ.1053 allows.
io::Json imo_criteria(const io::Json& indices, const ManeuverFacts& facts, const RecordedTest& test);

}  // namespace leeway
