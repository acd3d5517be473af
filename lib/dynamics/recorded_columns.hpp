#pragma once

#include <string>
#include <vector>

#include "io/json.hpp"
#include "ship/ship.hpp"

namespace leeway {

/// In which of two columns that say the same a simulated recording has its bow thruster and its wind. The words are
/// those of a data set's `recorded` and of the options of mmg-sim.
struct RecordedColumns {
  std::string bow_thruster = "n_bt_rps";  ///< or "i_bt", the pitch current, in its place
  std::string wind = "both";              ///< or "true", or "apparent" alone

  friend bool operator==(const RecordedColumns&, const RecordedColumns&) = default;
  static const std::vector<std::string>& bow_thruster_words();
  static const std::vector<std::string>& wind_words();
};

/// Keys bow_thruster, wind, both optional.
RecordedColumns parse_recorded_columns(const io::JsonObject& json);

/// A truth has all columns: i_bt beside n_bt where it is recorded. Throws InputError where the ship has no such thing.
void complete_truth(Trajectory& truth, const RecordedColumns& columns, const Ship& ship);

/// Takes from a recording the columns that are not recorded.
void leave_recorded(Trajectory& recording, const RecordedColumns& columns);

}  // namespace leeway
