#include "dynamics/run_notices.hpp"

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include "core/units.hpp"
#include "dynamics/straight_run.hpp"
#include "io/files.hpp"

using namespace leeway;
using Catch::Matchers::Contains;

TEST_CASE("run notices: revolutions that do not hold the speed are told with what would", "[dynamics]") {
  const Ship ship = read_ship("kvlcc2-l7");
  const double n = self_propulsion_n(ship, 1.5);
  CHECK_FALSE(speed_notice(ship, 1.5, n));
  CHECK_FALSE(speed_notice(ship, 1.5, 1.03 * n));
  const auto notice = speed_notice(ship, 1.5, 8.0);
  REQUIRE(notice);
  CHECK_THAT(*notice, Contains("1.5 m/s (--u0-mps)") && Contains("8 1/s (--n-p-rps)") &&
                          Contains(fmt::format("comes to {:.4g} m/s", steady_speed(ship, 8.0))) &&
                          Contains(fmt::format("{:.4g} 1/s would hold", n)));
  // Beyond what the propeller can do. From rest a ship gets under way: nothing to tell.
  CHECK_THAT(*speed_notice(ship, 10.0, 8.0), Contains("no revolutions within -18 to 18 1/s hold"));
  CHECK_FALSE(speed_notice(ship, 0.0, 8.0));
  CHECK_FALSE(speed_notice(ship, 0.0, 0.0));
  // A pilot's rudders slow the ship down, and cannot drive it.
  CHECK_FALSE(speed_notice(ship, 0.5, 8.0, true));
  CHECK(speed_notice(ship, 1.5, 8.0, true));
}

TEST_CASE("run notices: the shipped ships start near a steady speed, but for the one with errors planted",
          "[dynamics]") {
  for (const std::string& name : io::config_names("ships")) {
    CAPTURE(name);
    const Ship ship = read_ship(name);
    const auto notice = speed_notice(ship, ship.u0_mps, ship.propulsion().front().initial);
    CHECK(notice.has_value() == (name == "vectwin-3m-estimated"));
  }
}

TEST_CASE("run notices: a wind without a module, and rudder angles beyond the limits", "[dynamics]") {
  const Ship windless = read_ship("kvlcc2-l7"), twin = read_ship("vectwin-3m");
  CHECK_THAT(*wind_notice(windless, 10.0), Contains("no wind module: the wind of 10 m/s has no effect"));
  CHECK_FALSE(wind_notice(windless, 0.0));
  CHECK_FALSE(wind_notice(twin, 10.0));
  CHECK(rudder_notices(windless, {deg_to_rad(35.0), deg_to_rad(-35.0)}).empty());
  const auto notices = rudder_notices(windless, {deg_to_rad(40.0), deg_to_rad(-40.0)});
  REQUIRE(notices.size() == 1);
  CHECK_THAT(notices[0], Contains("40 and -40 deg") && Contains("limits -35 to 35 deg of delta"));
  // Each of two rudders has its own limits.
  CHECK(rudder_notices(twin, {deg_to_rad(60.0)}).size() == 1);
}
