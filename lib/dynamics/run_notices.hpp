#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/dataset.hpp"

/// What a user should know of a run that does what was asked for and hardly what was meant.
namespace leeway {

/// A straight run that begins at one speed and comes to rest at another by more than this share of the larger one.
inline constexpr double kSpeedMismatch = 0.05;

/// That these revolutions do not hold the surge through the water, where the ship comes to another speed on a straight
/// course in calm air: which one, and which revolutions would hold it.
///   only_slows  the rudders hold a speed below that one, as a pilot's VecTwin rudders do
std::optional<std::string> speed_notice(const Ship& ship, double u_mps, double n_rps, bool only_slows = false);

/// That the wind does nothing, where the ship has no wind module.
std::optional<std::string> wind_notice(const Ship& ship, double wind_speed_mps);
/// The same of a recorded wind.
std::optional<std::string> wind_notice(const Ship& ship, const Trajectory& recording);

/// For each rudder that cannot follow one of these orders [rad]: its limits.
std::vector<std::string> rudder_notices(const Ship& ship, const std::vector<double>& orders);

/// What of this holds for runs of a data set.
std::vector<std::string> dataset_notices(const DatasetSpec& spec);

}  // namespace leeway
