#pragma once

#include <optional>
#include <set>
#include <string>

#include "io/columns_map.hpp"
#include "recording/trajectory.hpp"

namespace leeway::io {

/// What is said of columns that no tool knows and, beside them, of those that a columns map names and the files lack;
/// nothing where all are known.
std::optional<std::string> unread_columns(const std::set<std::string>& ignored, const std::set<std::string>& absent);

/// Reads a recording ("-": standard input); units become SI and radians here and nowhere else.
///
/// An empty field is a missing sample (NaN); a row of empty fields only is passed over. Throws InputError for a
/// missing t_s, u_mps, vm_mps or r_degps, two columns for one channel, text or nan in a number, a row of another
/// length, a time that does not increase, one column of a wind without the other, or no row at all; IoError if the file
/// cannot be read.
/// With a map the channels are converted as it says: clock, scale, position on the earth, axes of the velocities,
/// derived channels.
///   keep_unknown  keep the columns that no tool knows as text, so that a copy has them
Trajectory read_trajectory(const std::string& path, const ColumnsMap* map = nullptr, bool keep_unknown = false);

/// Writes all channels of a trajectory under the names and units of docs/formats.md ("-": standard output), and behind
/// them the kept unknown columns; one that is called like a channel written is left out.
void write_trajectory(const std::string& path, const Trajectory& trajectory);

/// The text that write_trajectory writes.
std::string trajectory_text(const Trajectory& trajectory);

}  // namespace leeway::io
