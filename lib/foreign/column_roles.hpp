#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "foreign/clock_columns.hpp"
#include "foreign/raw_table.hpp"
#include "io/columns_map.hpp"

namespace leeway::foreign {

/// A column with what is proposed for it.
struct RoleColumn {
  std::size_t column = 0;
  std::string unit;  ///< as in columns maps; empty: not known
  double sign = 1.0;
  double scale = 1.0;   ///< a number's size in the unit, without the sign
  bool is_own = false;  ///< leeway's own name, which is meant as it stands
};

/// What is proposed for a table.
struct Roles {
  std::map<Channel, RoleColumn> channels;
  io::VelocityFrame frame = io::VelocityFrame::ship;
  io::PositionForm position = io::PositionForm::plane;
  std::vector<std::string> findings;    ///< what the kinematics say, with numbers
  std::vector<std::string> unknowable;  ///< what nobody can know from the file
  std::optional<double> misfit;         ///< of positions and velocities, else of heading and yaw rate
};

/// Roles by names, or by the kinematics where there are no names; then units, signs and axes by the kinematics.
Roles find_roles(const RawTable& table, const std::vector<NamedColumn>& meanings, const FoundClock& clock);

}  // namespace leeway::foreign
