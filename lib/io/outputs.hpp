#pragma once

#include <string>
#include <vector>

namespace leeway::io {

/// Throws UsageError where an output is one of the inputs or is to be written twice: also through symbolic and hard
/// links, other spellings of a path, and a standard stream that the shell leads to a file. For before the work. Outputs
/// that are not there yet, devices and pipes are never inputs.
///   inputs   all files that are read; folders and what does not exist are passed over
///   outputs  all files that will be written or removed; "" is an output that is not wanted
void require_apart(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

/// The files in a folder, not those below it; for a folder that is an input as a whole.
std::vector<std::string> files_in(const std::string& folder);

}  // namespace leeway::io
