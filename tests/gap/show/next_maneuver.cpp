#include "gap/show/next_maneuver.hpp"

#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "gap/show/maneuver_menu.hpp"

using namespace leeway;
using What = gap::Recommended::What;

TEST_CASE("next maneuver: the shortest that decides, else two, else what distinguishes most", "[gap][show]") {
  gap::NextPlan plan;
  plan.maneuvers = {{"long", "a", 600.0, 0.99}, {"short", "b", 200.0, 0.95}, {"shorter", "c", 100.0, 0.94}};
  const gap::Recommended decides = gap::recommended(plan, 0.6);
  CHECK(decides.what == What::maneuver);
  CHECK(plan.maneuvers[decides.place].name == "short");
  CHECK(decides.p_right == 0.95);

  gap::Policy policy;
  policy.show.decisive = 0.94;
  CHECK(plan.maneuvers[gap::recommended(plan, 0.6, policy).place].name == "shorter");

  // None decides: 0.94 is worth while, if it is more than 0.02 better than now.
  plan.maneuvers.erase(plan.maneuvers.begin(), plan.maneuvers.begin() + 2);
  CHECK(gap::recommended(plan, 0.6).what == What::maneuver);
  CHECK(gap::recommended(plan, 0.91).what == What::maneuver);
  CHECK(gap::recommended(plan, 0.93).what == What::nothing);

  // Two that decide come before one that does not, and before what could have been recorded.
  plan.maneuvers.push_back({"other", "d", 50.0, 0.8});
  plan.sequences = {{{0, 1}, 150.0, 0.97}};
  plan.records = {{"the water depth", "", 0.99}};
  CHECK(gap::recommended(plan, 0.6).what == What::sequence);
  plan.sequences.front().p_right = 0.945;  // no more than the first alone
  CHECK(gap::recommended(plan, 0.6).what == What::record);
  plan.records.front().p_right = 0.7;
  CHECK(gap::recommended(plan, 0.6).what == What::maneuver);

  // Nothing can surpass what was fitted: of that, most decides.
  plan.p_reachable = 0.8;
  plan.maneuvers = {{"long", "a", 600.0, 0.79}, {"short", "b", 200.0, 0.77}};
  plan.sequences.clear();
  CHECK(gap::recommended(plan, 0.6).place == 1);
}

TEST_CASE("next maneuver: the menu has lower speeds, and astern where the propeller reverses", "[gap][show]") {
  const auto has = [](const std::vector<gap::MenuItem>& menu, const std::string& part) {
    return std::ranges::count_if(menu,
                                 [&](const gap::MenuItem& item) { return item.name.find(part) != std::string::npos; });
  };
  const std::vector<gap::MenuItem> osaka = gap::maneuver_menu(read_ship("esso-osaka-3m"), 1.0, {}),
                                   vectwin = gap::maneuver_menu(read_ship("vectwin-3m"), 1.0, {});
  CHECK(has(osaka, "astern") == 1);
  CHECK(has(vectwin, "astern") == 0);
  CHECK(has(vectwin, "thruster pulses") == 3);
  CHECK(has(osaka, "50 % speed") >= 3);
  CHECK(has(osaka, "35 deg") == 2);

  gap::NextLimits limits;
  limits.rudder_deg = 8.0;
  const std::vector<gap::MenuItem> gentle = gap::maneuver_menu(read_ship("esso-osaka-3m"), 1.0, limits);
  CHECK(has(gentle, "35 deg") == 0);
  CHECK(has(gentle, "a zigzag 8/8") == 2);  // one of each speed
}
