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
  const std::set<std::string> allowed{"kLevels",
                                      "kTauLevel",
                                      "kWindLevel",
                                      "kStates",
                                      "kShipStates",
                                      "kErrorStart",
                                      "kWindStart",
                                      "kActuatorErrors",
                                      "kReceiverLevel",
                                      "kWidth",
                                      "kRows",
                                      "kDirections",
                                      "kToDegrees",
                                      "kPerSi",
                                      "kDirectionUnit_deg",
                                      "kFaultParameterCount",
                                      "kGroups",
                                      "kEvenMotions",
                                      "kChunk",
                                      "kDecaying"};
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

TEST_CASE("policy: no other file of lib/gap decides by a number in its text", "[gap][policy]") {
  // Numbers of formulas, and of how much work is done.
  const std::set<double> of_formulas{0.0, 0.25, 0.5,  0.75,  1.0,   2.0,   3.0,  4.0,
                                     6.0, 60.0, 90.0, 100.0, 180.0, 270.0, 360.0};
  // Quadrature and distributions, digits of a printed number, meters of a kilometer, names of maneuvers, numbers that
  // are as good as infinite.
  const std::set<std::string> allowed{"campaign.cpp 1e300",
                                      "state_space.hpp 1e9",
                                      "hypothesis.cpp 143.61952130254163",
                                      "locate_json.cpp 1e3",
                                      "summary.cpp 1e3",
                                      "numbers.cpp 0.1",
                                      "numbers.cpp 10.0",
                                      "channel_quality.cpp 9.0",
                                      "kinematic_windows.cpp 0.6",
                                      "kinematic_windows.cpp 5.0",
                                      "kinematic_windows.cpp 8.0",
                                      "kinematic_windows.cpp 18.0",
                                      "reading_odds.cpp 10.0",
                                      "readings.cpp 1000.0",
                                      "maneuver_menu.cpp 10.0",
                                      "maneuver_menu.cpp 20.0",
                                      "free_runs.cpp 0.6744897501960817",
                                      "free_runs.cpp 1.6448536269514722",
                                      "free_runs.cpp 2.5758293035489004"};
  const std::regex text(R"("(\\.|[^"\\])*"|//.*)"), number(R"((^|[^\w.])(\d+\.\d*(e[-+]?\d+)?|\d+e[-+]?\d+)(?!\w))");
  std::set<std::string> seen;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(LEEWAY_SOURCE_FOLDER "/lib/gap")) {
    const std::string path = entry.path().generic_string();
    if (entry.path().extension() != ".cpp" && entry.path().extension() != ".hpp") continue;
    if (path.find("/gap/policy/") != std::string::npos) continue;
    std::ifstream stream(path);
    for (std::string line; std::getline(stream, line);) {
      if (line.find("progress(") != std::string::npos || line.find("progress_(") != std::string::npos) continue;
      line = std::regex_replace(line, text, "");
      for (auto n = std::sregex_iterator(line.begin(), line.end(), number); n != std::sregex_iterator(); ++n) {
        const std::string literal = (*n)[2];
        if (of_formulas.contains(std::stod(literal))) continue;
        const std::string found = entry.path().filename().string() + " " + literal;
        seen.insert(found);
        CAPTURE(path, line);
        CHECK(allowed.contains(found));
      }
    }
  }
  CHECK(seen == allowed);
}
