#pragma once

#include <functional>
#include <string>
#include <vector>

#include "ship/ship.hpp"

namespace leeway {

/// What is unusual about a ship that can be read all the same: proportions, masses, speed, signs of derivatives, places
/// and sizes of propeller, rudder, thrusters and what the wind meets, limits of actuators, each with the usual range. A
/// file with masses in kg, a rudder ahead of midship or revolutions per minute says so here.
std::vector<std::string> implausible(const Ship& ship);

/// Who is told what implausible() says of each ship that read_ship() reads; at first nobody. The tools warn.
using ShipListener = std::function<void(const std::string& file, const std::string& warning)>;
void listen_to_ships(ShipListener listener);

/// Tells the listener.
void tell_implausible(const Ship& ship);

}  // namespace leeway
