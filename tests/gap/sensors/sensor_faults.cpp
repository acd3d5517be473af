#include "gap/sensors/sensor_faults.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include <catch2/catch.hpp>

using namespace leeway;

TEST_CASE("sensor faults: members of one name have the same traits, and name simpler ones that exist", "[gap][audit]") {
  std::set<std::string_view> late, in_forces;
  for (const gap::FaultCandidate& fault : gap::fault_library()) {
    CAPTURE(fault.name);
    const gap::FaultTraits& first = gap::traits_of(fault.name);
    CHECK(fault.traits.is_late_only == first.is_late_only);
    CHECK(fault.traits.shows_in_forces == first.shows_in_forces);
    CHECK(fault.traits.simpler == first.simpler);
    if (first.is_late_only) late.insert(fault.name);
    if (first.shows_in_forces) in_forces.insert(fault.name);
    if (!first.simpler.empty())
      CHECK(
          std::any_of(gap::fault_library().begin(), gap::fault_library().end(), [&](const gap::FaultCandidate& other) {
            return other.name == first.simpler && other.numbers.size() < fault.numbers.size();
          }));
  }
  CHECK(late == std::set<std::string_view>{"velocity-latency", "heading-latency", "rate-latency", "sensor-filter"});
  CHECK(in_forces ==
        std::set<std::string_view>{"heading-bias", "lever-arm", "log-scale", "log-bias", "rate-bias", "rate-scale"});
  CHECK_FALSE(gap::traits_of("tug").shows_in_forces);
}

TEST_CASE("sensor faults: factors say of which channel", "[gap][audit]") {
  CHECK(gap::find_fault_parameter("log_scale")->scaled == Channel::u);
  CHECK(gap::find_fault_parameter("sway_log_scale")->scaled == Channel::vm);
  CHECK(gap::find_fault_parameter("rate_scale")->scaled == Channel::r);
  CHECK_FALSE(gap::find_fault_parameter("rate_bias_degps")->scaled.has_value());
  CHECK(gap::find_fault_parameter("h_over_T") == nullptr);
}

TEST_CASE("sensor faults: no other file of lib/gap knows one by its name", "[gap][audit]") {
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(LEEWAY_SOURCE_FOLDER "/lib/gap")) {
    const std::string path = entry.path().generic_string();
    if (entry.path().extension() != ".cpp" || entry.path().filename() == "sensor_faults.cpp") continue;
    ++files;
    std::ifstream stream(path);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    for (const gap::FaultCandidate& fault : gap::fault_library()) {
      CAPTURE(path, fault.name);
      CHECK(text.find('"' + std::string(fault.name) + '"') == std::string::npos);
    }
    CAPTURE(path);
    CHECK(text.find("name.ends_with(") == std::string::npos);
  }
  CHECK(files > 50);
}
