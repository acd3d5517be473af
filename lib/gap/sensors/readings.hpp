#pragma once

#include <functional>
#include <initializer_list>
#include <string_view>
#include <utility>
#include <vector>

#include "recording/trajectory.hpp"

namespace leeway::gap {

/// A way to read a channel that differs from the stated convention.
struct ReadingEntry {
  std::string_view channel, name, says;
  std::function<void(Trajectory&)> apply;  ///< makes a recording of that kind follow leeway's conventions
  bool asks_fit = false;  ///< whether short times may leave it open, so that the fit is asked: it is of a faint wind
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

/// Multiplies a channel.
void scale_channel(Trajectory& recording, Channel channel, double factor);

}  // namespace leeway::gap
