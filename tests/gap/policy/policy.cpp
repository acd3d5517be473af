#include "gap/policy/policy.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>

#include <catch2/catch.hpp>

using namespace leeway;

TEST_CASE("policy: its hash changes with each value, and only then", "[gap][policy]") {
  gap::Policy policy;
  const std::string as_is = gap::policy_hash(policy);
  CHECK(as_is == gap::policy_hash());
  policy.sensors.huber += 1e-9;
  CHECK(gap::policy_hash(policy) != as_is);
  policy = {};
  policy.report.points_in_all += 1;
  CHECK(gap::policy_hash(policy) != as_is);
}

TEST_CASE("policy: no other file of lib/gap names a number of its own", "[gap][policy]") {
  // Sizes of types and of blocks of memory, places in a state, units: they decide nothing.
  const std::set<std::string> allowed{
      "kLevels", "kTauLevel", "kWindLevel",  "kStates",    "kShipStates", "kErrorStart",        "kWindStart",
      "kWidth",  "kRows",     "kDirections", "kToDegrees", "kPerSi",      "kDirectionUnit_deg", "kFaultParameterCount"};
  const std::regex statement(R"(constexpr[^;()]*?\bk[A-Z]\w*[^;]*;)"),
      number(R"(\b(k[A-Z]\w*)\s*(=\s*\{*|\{+)\s*[-+]?\.?[0-9])");
  std::size_t files = 0;
  std::set<std::string> seen;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(LEEWAY_SOURCE_FOLDER "/lib/gap")) {
    const std::string path = entry.path().generic_string();
    if (entry.path().extension() != ".cpp" && entry.path().extension() != ".hpp") continue;
    if (path.find("/gap/policy/") != std::string::npos) continue;
    ++files;
    std::ifstream stream(path);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    for (auto s = std::sregex_iterator(text.begin(), text.end(), statement); s != std::sregex_iterator(); ++s) {
      const std::string all = s->str();
      for (auto n = std::sregex_iterator(all.begin(), all.end(), number); n != std::sregex_iterator(); ++n) {
        const std::string name = (*n)[1];
        seen.insert(name);
        CAPTURE(path, name);
        CHECK(allowed.contains(name));
      }
    }
  }
  CHECK(files > 50);
  CHECK(seen == allowed);  // the search finds those that are there, and none is allowed that is gone
}
