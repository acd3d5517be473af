#include "recording/froude_law.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace leeway;

TEST_CASE("Froude's law: lengths, times, speeds and rates scale so that accelerations stay", "[recording]") {
  const FroudeLaw law(50.0);
  const double speed = law.of(Quantity::speed), time = law.of(Quantity::time);
  CHECK(speed / time == Approx(1.0));                                                // u'
  CHECK(speed * speed / law.of(Quantity::length) == Approx(1.0));                    // u^2/L
  CHECK(law.of(Quantity::angular_rate) * time == Approx(1.0));                       // an angle
  CHECK(law.of(Quantity::revolutions) * law.of(Quantity::length) == Approx(speed));  // u/(n D) stays
  CHECK(law.of(Quantity::angle) == 1.0);
  CHECK(law.of(Quantity::ratio) == 1.0);
}

TEST_CASE("Froude's law: a recording is scaled channel by channel, and absent channels stay absent", "[recording]") {
  Trajectory run;
  run[Channel::t] = {0.0, 7.0};
  run[Channel::u] = {3.5, kMissing};
  run[Channel::psi] = {0.4, 0.5};
  run[Channel::n_bt] = {-2.0, 1.0};
  const Trajectory small = scaled_down(run, FroudeLaw(4.0));
  CHECK(small[Channel::t] == std::vector<double>{0.0, 3.5});
  CHECK(small[Channel::u][0] == 1.75);
  CHECK(std::isnan(small[Channel::u][1]));
  CHECK(small[Channel::psi] == run[Channel::psi]);
  CHECK(small[Channel::n_bt] == std::vector<double>{-4.0, 2.0});
  CHECK_FALSE(small.has(Channel::vm));
}
