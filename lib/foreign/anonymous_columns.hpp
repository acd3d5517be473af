#pragma once

#include <optional>
#include <span>
#include <vector>

#include "foreign/motion_fit.hpp"

namespace leeway::foreign {

/// A column that is linear in the row's number: a clock, or what rounding has left of one.
struct LinearClock {
  std::size_t column;
  double step;         ///< from row to row, in the column's unit
  bool is_increasing;  ///< strictly; else it was rounded too much to be one
};
/// The first column that is one.
std::optional<LinearClock> find_linear_clock(const std::vector<std::vector<double>>& columns);

/// Which columns of a file without names are what, by the kinematics alone: those whose direction follows a heading are
/// the position, those that are its derivative the velocities, what the yaw rate answers to is the rudder, and what
/// hardly changes the propeller.
struct AnonymousColumns {
  std::optional<std::size_t> x0, y0, psi, u, vm, r, delta, n_p;
  io::VelocityFrame frame = io::VelocityFrame::ship;
};
///   taken  columns that are known to be something else, such as the clock
AnonymousColumns recognize_columns(const std::vector<std::vector<double>>& columns, const std::vector<bool>& taken,
                                   const std::vector<double>& t);

}  // namespace leeway::foreign
