#pragma once

#include <string>

#include "ship/ship.hpp"

namespace leeway {

/// A table of the shipped ships, a line each: name, L_pp, description.
std::string ship_list();

/// What a user reads to know a ship: particulars with units, force modules and actuators with their sources, a straight
/// run at the initial revolutions and self-propulsion at u0.
std::string ship_report(const Ship& ship);

}  // namespace leeway
