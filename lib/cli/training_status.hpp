#pragma once

#include <string>

#include "ensemble/training_status.hpp"

namespace leeway::cli {

/// One line for each member, and one for all: what `ens-train --status` prints.
std::string training_status_text(const std::string& folder, const ensemble::TrainingStatus& status);

}  // namespace leeway::cli
