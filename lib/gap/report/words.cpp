#include "gap/report/words.hpp"

#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "effects/description.hpp"

namespace leeway::gap {

std::string_view word(Verdict verdict) {
  switch (verdict) {
    case Verdict::mismatch:
      return "mismatch";
    case Verdict::no_mismatch:
      return "no-mismatch";
    case Verdict::undecided:
      break;
  }
  return "undecided";
}

std::string headline(const Findings& findings) {
  const std::string ship = findings.ship.empty() ? "the ship" : findings.ship;
  const std::string simulator = findings.ensemble ? "ensemble " + findings.ensemble->name : "simulator of " + ship;
  if (findings.grossly_inconsistent && findings.verdict != Verdict::no_mismatch)
    return fmt::format(
        "The recordings are far from the simulator of {}: another ship, scale or draft, or several things left out at "
        "once.",
        ship);
  switch (findings.verdict) {
    case Verdict::mismatch:
      return fmt::format("The {} and the recordings differ by more than noise and {}.", simulator,
                         findings.ensemble ? "the members' spread" : "stated uncertainty");
    case Verdict::no_mismatch:
      return fmt::format("The recordings agree with the {} within noise and {}.", simulator,
                         findings.ensemble ? "the members' spread" : "stated uncertainty");
    case Verdict::undecided:
      break;
  }
  return fmt::format("These recordings do not decide whether the {} lacks something.", simulator);
}

std::string headline(const Explanation& explanation) {
  std::vector<std::string> named;
  bool is_unknown = false;
  for (const std::string& name : explanation.chosen)
    if (search_start(name) == SearchStart::terms)
      is_unknown = true;
    else
      named.push_back(name);
  if (explanation.verdict == Verdict::no_mismatch) return "Nothing is missing that these recordings could show.";
  if (explanation.verdict == Verdict::undecided) return "These recordings do not decide whether something is missing.";
  if (named.empty()) return "Something is missing that the catalogue does not hold.";
  return fmt::format("{} explains the difference{}.", fmt::join(named, " with "),
                     is_unknown ? " in part; the rest is not in the catalogue" : "");
}

std::string frame_meaning(const std::string& name) {
  static constexpr std::pair<std::string_view, std::string_view> kMeanings[] = {
      {"body", "fixed to the ship"},
      {"earth", "fixed to the earth"},
      {"apparent-wind", "follows the apparent wind"},
      {"water-speed", "follows the speed through the water"},
      {"position", "belongs to the place"},
      {"actuator", "follows rudder, propeller or thruster"},
  };
  for (const auto& [known, meaning] : kMeanings)
    if (name == known) return std::string(meaning);
  return name;
}

}  // namespace leeway::gap
