#pragma once

#include <string>
#include <string_view>

#include "recording/trajectory.hpp"

namespace leeway::foreign {

/// What a column can be.
enum class Meaning {
  unknown,
  other,    ///< known, and nothing of a trajectory: roll, torque, an ordered rudder angle
  clock,    ///< time, also as a text
  date,     ///< beside a clock
  channel,  ///< as `channel` says
  latitude,
  longitude,
  speed,   ///< over ground
  course,  ///< over ground
};

/// What a column's name says of it.
struct NamedColumn {
  Meaning meaning = Meaning::unknown;
  Channel channel = Channel::t;
  std::string unit = {};          ///< as in columns maps; empty where the name has none
  bool is_earth = false;          ///< a velocity along the earth's axes
  double scale = 1.0;             ///< a number's size in `unit`: 0.3048 for feet, in m
  bool is_own = false;            ///< leeway's own name: meant as it stands
  bool is_time_of_day = false;    ///< a clock as hhmmss
  std::string foreign_unit = {};  ///< what stands as a unit and is none that is known, or none of this quantity
};

/// Reads a name such as "Rudder angle [deg]", "n_prop_rpm", "SOG(kn)".
NamedColumn meaning_of_name(std::string_view name, std::string_view unit_below);

/// Whether a text is a unit and nothing else: "[m/s]", "deg".
bool is_unit(std::string_view text);

}  // namespace leeway::foreign
