#include "cli/progress.hpp"

#include <algorithm>
#include <fcntl.h>
#include <thread>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "io/files.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using namespace std::chrono_literals;

namespace {

// What is written to the standard error, here a file, while `work` runs.
template <typename Work>
std::string standard_error_of(const Work& work) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("err", "");
  const int before = ::dup(STDERR_FILENO), log = ::open(file.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  ::dup2(log, STDERR_FILENO);
  work();
  ::dup2(before, STDERR_FILENO);
  ::close(before);
  ::close(log);
  return io::read_text(file);
}

}  // namespace

TEST_CASE("progress: a log file gets a line in every interval, also while nothing is reported", "[cli]") {
  const std::string log = standard_error_of([] {
    cli::Progress progress("working", 10.0, {}, cli::Progress::Lines::of_long_work, 50ms);
    std::this_thread::sleep_for(180ms);
    progress.update(3.0, "on it");
    std::this_thread::sleep_for(180ms);
  });
  CHECK(std::count(log.begin(), log.end(), '\n') >= 3);
  CHECK_THAT(log, StartsWith("working: 0 %, 0:00 so far\n"));
  CHECK_THAT(log, Contains("working: 30 %, on it, 0:0"));
}

TEST_CASE("progress: a line for each tenth, none of what takes a moment, and none with --quiet", "[cli]") {
  const auto twenty_steps = [](cli::Progress::Lines lines) {
    return standard_error_of([&] {
      cli::Progress progress("working", 20.0, {}, lines);
      for (int i = 0; i < 20; ++i) progress.advance();
    });
  };
  const std::string log = twenty_steps(cli::Progress::Lines::at_once);
  CHECK(std::count(log.begin(), log.end(), '\n') == 10);
  CHECK_THAT(log, StartsWith("working: 10 %, 0:00 left\n"));
  CHECK(twenty_steps(cli::Progress::Lines::of_long_work).empty());
  CHECK(standard_error_of([] {
          cli::CommonOptions quiet;
          quiet.quiet = true;
          const cli::Progress progress("working", 10.0, quiet, cli::Progress::Lines::at_once, 10ms);
          std::this_thread::sleep_for(50ms);
        }).empty());
}
