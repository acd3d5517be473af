#include "gap/sensors/sensor_faults.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include <catch2/catch.hpp>

using namespace leeway;

TEST_CASE("sensor faults: members of one name have the same traits, and name simpler ones that exist", "[gap][audit]") {
  std::set<std::string_view> late;
  for (const gap::FaultCandidate& fault : gap::fault_library()) {
    CAPTURE(fault.name);
    const gap::FaultTraits& first = gap::traits_of(fault.name);
    CHECK(fault.traits.is_late_only == first.is_late_only);
    CHECK(fault.traits.simpler == first.simpler);
    if (first.is_late_only) late.insert(fault.name);
    if (!first.simpler.empty())
      CHECK(
          std::any_of(gap::fault_library().begin(), gap::fault_library().end(), [&](const gap::FaultCandidate& other) {
            return other.name == first.simpler && other.numbers.size() < fault.numbers.size();
          }));
  }
  CHECK(late == std::set<std::string_view>{"velocity-latency", "heading-latency", "rate-latency", "sensor-filter"});
  CHECK_FALSE(gap::traits_of("tug").is_late_only);
}

TEST_CASE("sensor faults: parameters are known by their names, and others are none", "[gap][audit]") {
  CHECK(gap::find_fault_parameter("rate_scale")->parameter == gap::FaultParameter::rate_scale);
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
