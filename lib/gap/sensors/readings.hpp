#pragma once

#include <functional>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "recording/trajectory.hpp"

namespace leeway::gap {

/// A way to read a channel that differs from the stated convention.
struct ReadingEntry {
  std::string_view channel, name, says;
  Channel of;  ///< which channel, or the first of those that it is of: delta stands for all rudders
  std::function<void(Trajectory&)> apply;  ///< makes a recording of that kind follow leeway's conventions
  bool asks_fit = false;     ///< whether short times may leave it open, so that the fit is asked: it is of a faint wind
  bool swaps_winds = false;  ///< whether it takes the true wind for the apparent one, or the other way round
  double least_recorded = 0.0;  ///< largest angle in the recordings [rad, as they stand], from which on it is possible
  double most_recorded = std::numeric_limits<double>::infinity();  ///< and up to which it is
};

/// All readings. A recording is reread in this order.
const std::vector<ReadingEntry>& readings();
/// Nothing where there is none of that name.
const ReadingEntry* find_reading(std::string_view channel, std::string_view name);
/// Those of (channel, name).
std::vector<const ReadingEntry*> pick_readings(
    std::initializer_list<std::pair<std::string_view, std::string_view>> names);

/// The recordings as they read under these readings.
std::vector<Trajectory> applied(std::vector<Trajectory> recordings, const std::vector<const ReadingEntry*>& which);

/// What judges a reading: how position, heading and velocities go together, or the ship's forces.
bool is_of_motion(Channel channel);
bool is_of_wind(Channel channel);
/// Nothing for a channel of no reading.
std::optional<Channel> channel_of_reading(std::string_view channel);

/// Multiplies a channel.
void scale_channel(Trajectory& recording, Channel channel, double factor);

}  // namespace leeway::gap
