#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/trajectory.hpp"

namespace leeway::io {

/// A unit in which a file may have a quantity.
struct Unit {
  Quantity quantity;
  std::string_view suffix;   ///< in names of columns, and in columns maps
  double factor;             ///< to SI
  std::string_view printed;  ///< in messages
};

/// The unit of this suffix for a quantity; nothing where there is none.
std::optional<Unit> unit_of(Quantity quantity, std::string_view suffix);
/// The suffixes of all units of a quantity.
std::vector<std::string_view> units_of(Quantity quantity);
/// "speed", where the suffix is a unit of speed; empty for what is no unit.
std::string_view quantity_measured_in(std::string_view suffix);
/// "a length", in messages.
std::string_view described(Quantity quantity);

/// A column in leeway's own form.
struct KnownColumn {
  Channel channel;
  Unit unit;
};
/// "psi_rad" -> the channel psi in rad; nothing for a name that is not ours.
std::optional<KnownColumn> known_column(std::string_view name);

}  // namespace leeway::io
