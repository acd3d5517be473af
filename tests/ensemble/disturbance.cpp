#include "ensemble/disturbance.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace leeway;
using namespace leeway::ensemble;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("disturbance: stationary with the stated variance and correlation, whatever the step", "[ensemble]") {
  Disturbance disturbance;
  disturbance.axes[0] = {{2e-3, 4.0}};
  disturbance.axes[2] = {{1e-3, 1.5}, {3e-3, 20.0}};
  CHECK_FALSE(disturbance.is_zero());
  constexpr int kPaths = 20000;
  for (const double dt_s : {0.5, 1.0}) {
    Vec3<double> first = Vec3<double>::Zero(), last = Vec3<double>::Zero(), product = Vec3<double>::Zero();
    for (std::uint64_t i = 0; i < kPaths; ++i) {
      RandomStream random(5, "paths", i);
      DisturbancePath path(disturbance, dt_s, random);
      const Vec3<double> at_start = path.next(random);
      Vec3<double> later = at_start;
      for (double t = dt_s; t < 6.0 + 0.5 * dt_s; t += dt_s) later = path.next(random);
      first += at_start.cwiseAbs2() / kPaths;
      last += later.cwiseAbs2() / kPaths;
      product += at_start.cwiseProduct(later) / kPaths;
    }
    // Four standard errors of a mean square over so many paths are 4 %.
    const double yaw = 1e-6 + 9e-6;
    CHECK_THAT(first(0), WithinRel(4e-6, 0.04));
    CHECK_THAT(last(0), WithinRel(4e-6, 0.04));
    CHECK_THAT(first(2), WithinRel(yaw, 0.04));
    CHECK_THAT(last(2), WithinRel(yaw, 0.04));
    CHECK(first(1) == 0.0);
    CHECK_THAT(product(0), WithinAbs(4e-6 * std::exp(-6.0 / 4.0), 0.04 * 4e-6));
    CHECK_THAT(product(2), WithinAbs(1e-6 * std::exp(-6.0 / 1.5) + 9e-6 * std::exp(-6.0 / 20.0), 0.04 * yaw));
  }
}

TEST_CASE("disturbance: none draws nothing and adds nothing", "[ensemble]") {
  CHECK(Disturbance().is_zero());
  RandomStream random(1, "none"), untouched(1, "none");
  DisturbancePath path({}, 1.0, random);
  CHECK(path.next(random).isZero(0.0));
  CHECK(random.uniform() == untouched.uniform());
}
