#include "core/parallel.hpp"

#include <algorithm>
#include <limits>
#include <sys/resource.h>

namespace leeway {

std::size_t threads_with_room() {
  rlimit space{}, stack{};
  if (::getrlimit(RLIMIT_AS, &space) != 0 || space.rlim_cur == RLIM_INFINITY)
    return std::numeric_limits<std::size_t>::max();
  constexpr rlim_t kMegabyte = 1 << 20, kHeap = 64 * kMegabyte, kStack = 8 * kMegabyte;
  const bool has_stack = ::getrlimit(RLIMIT_STACK, &stack) == 0 && stack.rlim_cur != RLIM_INFINITY;
  // glibc reserves a heap for a thread beside its stack. The other half of the space is for what the tasks allocate.
  return std::max<std::size_t>(1, space.rlim_cur / 2 / (kHeap + (has_stack ? stack.rlim_cur : kStack)));
}

}  // namespace leeway
