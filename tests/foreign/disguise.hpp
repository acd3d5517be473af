#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/units.hpp"
#include "dynamics/maneuvers.hpp"
#include "dynamics/simulation.hpp"
#include "recording/trajectory.hpp"
#include "ship/ship.hpp"

namespace leeway::test {

/// A simulated zigzag in calm water, every half second.
inline Trajectory simulated_zigzag(const std::string& name = "kvlcc2-l7") {
  const Ship ship = read_ship(name);
  const auto maneuver = zigzag(ship, 20.0 * kDegree, 20.0 * kDegree);
  return simulate(SimulatedShip(ship), *maneuver, WindProcess::steady(0.0, 0.0), {0.1, 0.5, 100.0});
}

/// A simulated turning circle in calm water, every half second.
inline Trajectory simulated_turn(double rudder_deg, const std::string& name = "kvlcc2-l7") {
  const Ship ship = read_ship(name);
  const auto maneuver = turning(ship, rudder_deg * kDegree);
  return simulate(SimulatedShip(ship), *maneuver, WindProcess::steady(0.0, 0.0), {0.1, 0.5, 200.0});
}

/// A column of a foreign file: its name and its text in a row.
using ForeignColumn = std::pair<std::string, std::function<std::string(const Trajectory&, std::size_t)>>;

/// A number: a channel in SI times a factor, with 10 digits.
inline ForeignColumn column(const std::string& name, Channel channel, double factor) {
  return {name, [=](const Trajectory& t, std::size_t i) { return fmt::format("{:.10g}", t[channel][i] * factor); }};
}

/// The same of a function of the row.
inline ForeignColumn column(const std::string& name, std::function<double(const Trajectory&, std::size_t)> value) {
  return {name, [=](const Trajectory& t, std::size_t i) { return fmt::format("{:.12g}", value(t, i)); }};
}

inline std::string foreign_text(const Trajectory& t, const std::vector<ForeignColumn>& columns, char delimiter = ',',
                                bool has_header = true, bool decimal_comma = false) {
  std::string text;
  for (std::size_t c = 0; has_header && c < columns.size(); ++c)
    text += (c > 0 ? std::string(1, delimiter) : "") + columns[c].first;
  if (has_header) text += '\n';
  for (std::size_t i = 0; i < t.size(); ++i) {
    std::string row;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (c > 0) row += delimiter;
      std::string field = columns[c].second(t, i);
      const bool is_number = field.find(':') == std::string::npos && std::count(field.begin(), field.end(), '.') < 2;
      if (decimal_comma && is_number) std::replace(field.begin(), field.end(), '.', ',');
      row += field;
    }
    text += row + '\n';
  }
  return text;
}

inline double north(const Trajectory& t, std::size_t i) {
  return t[Channel::u][i] * std::cos(t[Channel::psi][i]) - t[Channel::vm][i] * std::sin(t[Channel::psi][i]);
}
inline double east(const Trajectory& t, std::size_t i) {
  return t[Channel::u][i] * std::sin(t[Channel::psi][i]) + t[Channel::vm][i] * std::cos(t[Channel::psi][i]);
}

inline double speed(const Trajectory& t, std::size_t i) { return std::hypot(t[Channel::u][i], t[Channel::vm][i]); }
inline double course_deg(const Trajectory& t, std::size_t i) {
  return std::fmod(std::atan2(east(t, i), north(t, i)) / kDegree + 360.0, 360.0);
}

}  // namespace leeway::test
