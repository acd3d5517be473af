#pragma once

#include <string>

namespace leeway::cli {

/// From now on, what ends the program for want of memory where no exception can pass (a library's destructor that
/// allocates) is exit code 1 with one line, not an abort.
void end_in_order_without_memory(const std::string& program);

}  // namespace leeway::cli
