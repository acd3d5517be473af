#pragma once

#include <map>
#include <string>
#include <vector>

#include "recording/trajectory.hpp"

namespace leeway::io {

/// How the columns of a foreign recording are called: a columns map as in docs/formats.md.
struct ColumnsMap {
  struct Source {
    Channel channel;
    double factor;     ///< file value times factor is SI
    std::string unit;  ///< suffix, for messages
  };
  std::map<std::string, Source> columns;  ///< by the foreign column name
  std::vector<std::string> missing;       ///< texts that mark a missing sample, besides the empty field
};

/// Reads a columns map: a path, or the name of a shipped one such as "frt-ds-esso".
ColumnsMap read_columns_map(const std::string& name_or_path);

/// Reads a recording ("-": standard input); units become SI and radians here and nowhere else.
///
/// An empty field is a missing sample (NaN); a row of empty fields only is passed over. Throws InputError for a
/// missing t_s, u_mps, vm_mps or r_degps, two columns for one channel, text or nan in a number, a row of another
/// length, a time that does not increase, one column of a wind without the other, or no row at all; IoError if the file
/// cannot be read.
///   keep_unknown  keep the columns that no tool knows as text, so that a copy has them
Trajectory read_trajectory(const std::string& path, const ColumnsMap* map = nullptr, bool keep_unknown = false);

/// Writes all channels of a trajectory under the names and units of docs/formats.md ("-": standard output), and behind
/// them the kept unknown columns; one that is called like a channel written is left out.
void write_trajectory(const std::string& path, const Trajectory& trajectory);

/// The text that write_trajectory writes.
std::string trajectory_text(const Trajectory& trajectory);

}  // namespace leeway::io
