#include <algorithm>
#include <sstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "io/json.hpp"
#include "nn/rollout.hpp"
#include "run.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using test::Outcome;
using test::TemporaryFolder;

namespace {

// The kernel that each line of the output names.
std::vector<std::string> kernels_of(const std::string& lines) {
  std::vector<std::string> names;
  std::istringstream stream(lines);
  for (std::string line; std::getline(stream, line);) {
    const io::Json json = io::Json::parse(line);
    names.push_back(json.at("kernel"));
    CHECK(json.at("path") == json.at("kernel"));
  }
  return names;
}

}  // namespace

TEST_CASE("leeway-bench: --kernel chooses the kernel, and the line names it", "[cli][bench][long]") {
  const TemporaryFolder folder;
  const auto train = [&](const std::string& kernel) {
    const Outcome outcome = run(folder, "leeway-bench train --repeats 1 --jobs 1" + kernel);
    CAPTURE(outcome.err);
    REQUIRE(outcome.exit_code == 0);
    return kernels_of(outcome.out);
  };
  CHECK(train("") == nn::available_kernels());
  CHECK(train(" --kernel auto") == std::vector{nn::available_kernels().front()});
  CHECK(train(" --kernel portable") == std::vector<std::string>{"portable"});
}

TEST_CASE("leeway-bench: an option that the benchmark would ignore is refused", "[cli][bench]") {
  const TemporaryFolder folder;
  const auto check_refused = [&](const std::string& options, const std::string& message) {
    CAPTURE(options);
    const Outcome outcome = run(folder, "leeway-bench " + options);
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, Contains(message));
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
  };
  for (const std::string benchmark : {"train", "predict", "pd"})
    check_refused(benchmark + " --kernel mmx", "error: kernel 'mmx' is unknown or not available on this processor");
  check_refused("sim --kernel portable", "error: --kernel does not apply to the benchmark 'sim'");
  check_refused("gap --kernel auto", "error: --kernel does not apply to the benchmark 'gap'");
  check_refused("fly", "error: benchmark");
}
