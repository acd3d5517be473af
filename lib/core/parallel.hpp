#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

namespace leeway {

/// How many threads leave room for their tasks' memory, where the address space is limited (ulimit -v); at least 1.
std::size_t threads_with_room();

/// Calls task(i) for i in [0, n) on at most `jobs` threads, on fewer where the system refuses more or limits the
/// address space; the tasks share nothing that they write. All tasks are tried until one fails; then the exception of
/// the lowest failed index is thrown, whatever the number of threads.
template <typename Task>
void parallel_for(std::size_t n, std::size_t jobs, const Task& task) {
  std::vector<std::exception_ptr> failures(n);
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  const auto work = [&] {
    // A task that is taken is run: otherwise one could be skipped after a later one has failed.
    while (!failed) {
      const std::size_t i = next++;
      if (i >= n) break;
      try {
        task(i);
      } catch (...) {
        failures[i] = std::current_exception();
        failed = true;
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    const std::size_t most = n < 2 || jobs < 2 ? 1 : std::min({jobs, n, threads_with_room()});
    try {
      for (std::size_t k = 1; k < most; ++k) threads.emplace_back(work);
    } catch (const std::system_error&) {  // no more threads here, or no memory for them: those there are do the work
    } catch (const std::bad_alloc&) {
    }
    work();
  }
  for (const auto& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace leeway
