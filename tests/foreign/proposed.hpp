#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "foreign/proposal.hpp"
#include "io/columns_map.hpp"
#include "io/trajectory_csv.hpp"
#include "temporary_folder.hpp"

namespace leeway::test {

inline const std::vector<Channel> kEverything{Channel::t,  Channel::u,  Channel::vm,    Channel::r,  Channel::psi,
                                              Channel::x0, Channel::y0, Channel::delta, Channel::n_p};

/// Read through the map that is proposed for it, a disguised recording is the one that was simulated. Gives the map.
inline io::Json check_proposal(const std::string& text, const Trajectory& truth, const std::vector<Channel>& channels,
                               double tolerance = 1e-6) {
  const TemporaryFolder folder;
  const foreign::Proposal proposal = foreign::propose_columns_map(folder.write("raw.txt", text));
  const std::string map_text = foreign::map_text(proposal);
  INFO(map_text);
  const io::ColumnsMap map = io::read_columns_map(folder.write("map.json", map_text));
  const Trajectory read = io::read_trajectory(folder / "raw.txt", &map);
  CHECK(read.size() == truth.size());
  for (const Channel channel : channels) {
    CAPTURE(info(channel).name);
    CHECK(read.has(channel));
    if (!read.has(channel) || read.size() != truth.size()) continue;
    double worst = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < read.size(); ++i) {
      const double difference = read[channel][i] - truth[channel][i];
      worst = std::max(worst, std::abs(channel == Channel::t ? difference - read[channel][0] : difference));
      largest = std::max(largest, std::abs(truth[channel][i]));
    }
    CHECK(worst <= tolerance * std::max(1.0, largest));
  }
  return proposal.map;
}

/// The notes of a map that is proposed.
inline std::string notes_of(const io::Json& map) {
  std::string notes;
  for (const io::Json& note : map["notes"]) notes += note.get<std::string>() + "\n";
  return notes;
}

}  // namespace leeway::test
