#include "gap/show/next_maneuver.hpp"

#include <catch2/catch.hpp>

using namespace leeway;

TEST_CASE("next maneuver: the shortest that decides, else the best one, and only if it gains", "[gap][show]") {
  const std::vector<gap::NextManeuver> menu{
      {"long", "a", 600.0, 0.99}, {"short", "b", 200.0, 0.95}, {"shorter", "c", 100.0, 0.94}};
  const gap::Recommended decides = gap::recommended(menu, 0.6);
  CHECK(menu[decides.place].name == "short");
  CHECK(decides.is_worthwhile);
  CHECK_FALSE(gap::recommended(menu, 0.94).is_worthwhile);  // 0.95 is no more than 0.02 better

  const std::vector<gap::NextManeuver> none_decides(menu.begin() + 2, menu.end());
  CHECK(gap::recommended(none_decides, 0.6).place == 0);
  CHECK(gap::recommended(none_decides, 0.91).is_worthwhile);
  CHECK_FALSE(gap::recommended(none_decides, 0.93).is_worthwhile);

  gap::Policy policy;
  policy.show.decisive = 0.94;
  CHECK(menu[gap::recommended(menu, 0.6, policy).place].name == "shorter");
}
