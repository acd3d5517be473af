#include "recording/origin.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace leeway;

TEST_CASE("origin: positions on a far grid are counted from the first one, and back", "[recording]") {
  Trajectory run;
  run[Channel::t] = {0.0, 1.0, 2.0};
  run[Channel::x0] = {kMissing, 5933120.4, 5933121.0};
  run[Channel::y0] = {568440.0, 568440.2, kMissing};
  std::vector<Trajectory> runs{run, run};
  const auto origin = far_origin(runs, 300.0);
  REQUIRE(origin);
  CHECK(origin->x0_m == 5933120.0);
  CHECK(origin->y0_m == 568440.0);
  CHECK(origin->text() == "x0 = 5933120 m, y0 = 568440 m");
  count_from(*origin, runs);
  CHECK(runs[1][Channel::x0][1] == Approx(0.4));
  CHECK(std::isnan(runs[1][Channel::x0][0]));
  CHECK_FALSE(far_origin(runs, 300.0));
  count_from(*origin, runs, -1.0);
  CHECK(runs[0][Channel::y0][1] == 568440.2);

  SECTION("one that comes near the origin is counted from there") {
    runs[1][Channel::x0][1] = 100.0;
    runs[1][Channel::y0][1] = -200.0;
    CHECK_FALSE(far_origin(runs, 300.0));
  }
  SECTION("without positions there is nothing to count") {
    for (Trajectory& one : runs) one[Channel::y0].clear();
    CHECK_FALSE(far_origin(runs, 300.0));
  }
}
