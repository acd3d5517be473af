#include "cli/resources.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <exception>
#include <malloc.h>
#include <new>
#include <unistd.h>

#include "cli/options.hpp"

namespace leeway::cli {
namespace {

std::array<char, 64> message{};  // ready beforehand: then there is no memory for it

[[noreturn]] void end() {
  try {
    if (std::current_exception()) throw;
  } catch (const std::bad_alloc&) {
    std::size_t length = 0;
    while (length < message.size() && message[length] != '\0') ++length;
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, message.data(), length);
    ::_exit(kComputationFailed);
  } catch (...) {
  }
  std::abort();
}

}  // namespace

void end_in_order_without_memory(const std::string& program) {
  const std::string text = program + ": error: out of memory\n";
  std::copy_n(text.begin(), std::min(text.size(), message.size()), message.begin());
  std::set_terminate(end);
}

void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kMegabyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);  // the most that it takes
  mallopt(M_TRIM_THRESHOLD, 256 * kMegabyte);
#endif
}

}  // namespace leeway::cli
