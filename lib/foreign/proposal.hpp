#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "io/json.hpp"

namespace leeway::foreign {

/// A columns map that somebody is to check.
struct Proposal {
  io::Json map;                         ///< as docs/formats.md describes, with `description` and `notes`
  std::vector<std::string> unknowable;  ///< what nobody can know from the file; these stand in `notes` as well
};

/// Proposes a columns map for a recording whose columns are not known: its form (delimiter, decimal, header, encoding)
/// by its first lines; what columns are by their names and units, where they have any; and signs, units, axes of
/// velocities, and whatever has no name, by the kinematics (motion_fit.hpp). Throws IoError, or InputError where the
/// file holds no table of numbers.
Proposal propose_columns_map(const std::string& path);

/// The map as JSON, a line for each column.
std::string map_text(const Proposal& proposal);

}  // namespace leeway::foreign
