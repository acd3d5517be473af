#pragma once

#include <string>
#include <vector>

#include "ensemble/model_files.hpp"

namespace leeway::ensemble {

/// What a training that is wanted has otherwise than the one that a folder holds, a clause each: settings, seed and
/// recordings, "epochs: expected 7, found 6". Empty where these are the same. The number of members is no difference.
///   found  as read_header() has it
std::vector<std::string> training_differences(const EnsembleHeader& found, const EnsembleHeader& expected);

}  // namespace leeway::ensemble
