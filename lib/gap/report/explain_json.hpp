#pragma once

#include "gap/result/explanation.hpp"
#include "io/json.hpp"

namespace leeway::gap {

/// The contents of report.json but for `provenance`; keys and units in docs/gap-explain.md. A number that is not finite
/// becomes null.
io::Json to_json(const Explanation& explanation);

/// The file that holds the ship as it sails in one recording, where recordings differ.
std::string ship_file(const std::string& recording);

/// The file that holds the path of a current that varies in one recording.
std::string current_file(const std::string& recording);

/// The ship's JSON with what was found, as it stands in ship.json: effects are added, coefficient factors multiply
/// those that are there, a network takes the place of one that is there; all else stays as it is.
///   of         the contents of the ship's file
///   recording  one of Explanation::effects_in; empty: in any
io::Json ship_with(io::Json of, const Explanation& explanation, const std::string& recording = "");

}  // namespace leeway::gap
