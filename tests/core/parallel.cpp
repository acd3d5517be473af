#include "core/parallel.hpp"

#include <chrono>
#include <stdexcept>
#include <string>

#include <catch2/catch.hpp>

using namespace leeway;

TEST_CASE("parallel_for: every index is called once, whatever the number of threads", "[core][parallel]") {
  for (const std::size_t jobs : {0, 1, 3, 50}) {
    std::vector<int> calls(23, 0);
    parallel_for(calls.size(), jobs, [&](std::size_t i) { ++calls[i]; });
    CHECK(calls == std::vector<int>(23, 1));
  }
  parallel_for(0, 4, [](std::size_t) { FAIL("there is nothing to call"); });
}

TEST_CASE("parallel_for: the exception of the lowest failing index comes out", "[core][parallel]") {
  for (const std::size_t jobs : {1, 2, 4, 8})
    for (int repetition = 0; repetition < 50; ++repetition) {
      std::string caught;
      try {
        parallel_for(40, jobs, [](std::size_t i) {
          // The lower failure takes longer, so that the upper one comes first in time.
          if (i == 5) std::this_thread::sleep_for(std::chrono::microseconds(200));
          if (i == 5 || i == 7) throw std::runtime_error(std::to_string(i));
        });
      } catch (const std::runtime_error& error) {
        caught = error.what();
      }
      REQUIRE(caught == "5");
    }
}

TEST_CASE("parallel_for: tasks far behind a failure are not begun", "[core][parallel]") {
  std::atomic<int> begun{0};
  CHECK_THROWS_AS(parallel_for(100'000, 2,
                               [&](std::size_t i) {
                                 ++begun;
                                 if (i == 0) throw std::runtime_error("first");
                                 std::this_thread::sleep_for(std::chrono::microseconds(20));
                               }),
                  std::runtime_error);
  CHECK(begun < 100'000);
}
