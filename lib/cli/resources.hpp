#pragma once

#include <string>

namespace leeway::cli {

/// From now on, what ends the program for want of memory where no exception can pass (a library's destructor that
/// allocates) is exit code 1 with one line, not an abort.
void end_in_order_without_memory(const std::string& program);

/// From now on, memory that is freed stays with the program, up to 256 MB: large matrices are made anew all the time,
/// and pages that go to and fro are cleared by the system each time, a tenth of the time of gap-explain
/// (docs/performance.md).
void keep_freed_memory();

}  // namespace leeway::cli
