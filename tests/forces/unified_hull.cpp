#include "forces/unified_hull.hpp"

#include <catch2/catch.hpp>

#include "dynamics/model_parts.hpp"
#include "forces/registry.hpp"
#include "ship/ship.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

UnifiedHull<double> hull_of(const char* name) {
  const Ship ship = read_ship(name);
  return {std::get<UnifiedHullCoefficients<double>>(ship.modules->hull), ship.particulars};
}

// Midpoint rule with so many strips that its error is below 1e-9 of the integrals.
Vec2<double> strips(double v, double b) {
  constexpr int kStrips = 200000;
  Vec2<double> sum = Vec2<double>::Zero();
  for (int i = 0; i < kStrips; ++i) {
    const double y = (i + 0.5) / kStrips - 0.5;  // x/L
    const double w = v + 2.0 * b * y;
    sum += Vec2<double>(std::abs(w) * w, std::abs(w) * w * y) / kStrips;
  }
  return sum;
}

}  // namespace

TEST_CASE("hull: the closed cross-flow integrals agree with fine quadrature", "[forces][hull]") {
  for (const double v : {-0.31, -0.05, 0.0, 1e-9, 0.07, 0.4})
    for (const double b : {-0.5, -0.07, -1e-8, 0.0, 0.03, 0.07, 0.071, 0.62}) {
      CAPTURE(v, b);
      const Vec2<double> exact = cross_flow_integrals(v, b), quadrature = strips(v, b);
      CHECK_THAT(exact(0), WithinAbs(quadrature(0), 1e-9));
      CHECK_THAT(exact(1), WithinAbs(quadrature(1), 1e-9));
    }
}

TEST_CASE("hull: the cross-flow integrals are continuous where the flow starts to change sign", "[forces][hull]") {
  for (const double v : {-0.2, 0.13})
    for (const double side : {-1.0, 1.0}) {
      const double b = side * std::abs(v), step = 1e-9;
      const Vec2<double> inside = cross_flow_integrals(v, b * (1.0 + step));
      const Vec2<double> outside = cross_flow_integrals(v, b * (1.0 - step));
      CHECK_THAT(inside(0), WithinRel(outside(0), 1e-8));
      CHECK_THAT(inside(1), WithinRel(outside(1), 1e-8));
    }
  // A slow turn keeps all its digits: N is v b / 3 exactly.
  CHECK_THAT(cross_flow_integrals(0.3, 1e-13)(1), WithinRel(0.3 * 1e-13 / 3.0, 1e-14));
}

TEST_CASE("hull: a mirrored motion gives the mirrored force", "[forces][hull]") {
  for (const char* name : {"vectwin-3m", "esso-osaka-3m"}) {
    const UnifiedHull<double> hull = hull_of(name);
    for (const double u : {-0.3, 0.0, 0.46})
      for (const double v_m : {0.0, 0.05, 0.3})
        for (const double r : {-0.10, 0.0, 0.04}) {
          CAPTURE(name, u, v_m, r);
          const Vec3<double> starboard = hull.force({u, v_m, r}), port = hull.force({u, -v_m, -r});
          CHECK(port(0) == starboard(0));
          CHECK(port(1) == -starboard(1));
          CHECK(port(2) == -starboard(2));
        }
  }
}

TEST_CASE("hull: it resists every motion and vanishes at rest", "[forces][hull]") {
  const UnifiedHull<double> hull = hull_of("vectwin-3m");
  CHECK(hull.force(Vec3<double>::Zero()).isZero(0.0));
  CHECK(hull.force({0.4, 0.0, 0.0})(0) < 0.0);
  CHECK(hull.force({-0.4, 0.0, 0.0})(0) > 0.0);
  CHECK(hull.force({0.0, 0.1, 0.0})(1) < 0.0);
  CHECK(hull.force({0.0, 0.0, 0.1})(2) < 0.0);
  CHECK(hull.force({0.0, 0.0, -0.1})(2) > 0.0);
}

TEST_CASE("hull: the force is continuous through rest, sideways and straight astern", "[forces][hull]") {
  const UnifiedHull<double> hull = hull_of("esso-osaka-3m");
  const auto jump = [&](const Vec3<double>& a, const Vec3<double>& b) {
    return (hull.force(a) - hull.force(b)).norm();
  };
  CHECK(jump({1e-7, 1e-7, 0.05}, {-1e-7, -1e-7, 0.05}) < 1e-4);  // N; forces at these states are of order 1
  CHECK(jump({1e-9, 0.2, 0.05}, {-1e-9, 0.2, 0.05}) < 1e-6);
  CHECK(jump({-0.3, 1e-9, 0.05}, {-0.3, -1e-9, 0.05}) < 1e-6);  // drift angle 180 deg
  CHECK(jump({0.3, 1e-9, 1e-9}, {0.3, -1e-9, -1e-9}) < 1e-6);
}
