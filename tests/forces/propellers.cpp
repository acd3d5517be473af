#include <catch2/catch.hpp>

#include "forces/four_quadrant_propeller.hpp"
#include "forces/kang_propeller.hpp"
#include "forces/registry.hpp"
#include "ship/ship.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

KangPropeller<double> kang(double v_P_sign = -1.0) {
  const Ship ship = read_ship("vectwin-3m");
  auto c = std::get<KangPropellerCoefficients<double>>(*ship.modules->propeller);
  c.v_P_sign = v_P_sign;
  return {c, ship.particulars};
}

FourQuadrantPropeller<double> four_quadrant() {
  const Ship ship = read_ship("esso-osaka-3m");
  return {std::get<FourQuadrantPropellerCoefficients<double>>(*ship.modules->propeller), ship.particulars};
}

}  // namespace

TEST_CASE("Kang propeller: bollard thrust follows from K_T(0) and the deduction at rest", "[forces][propeller]") {
  const double n = 10.0, D = 0.1001;
  const PropellerFlow<double> flow = kang().flow(Vec3<double>::Zero(), n);
  CHECK_THAT(flow.force(0), WithinRel(998.0 * n * n * std::pow(D, 4) * 0.2794, 1e-12));
  CHECK(flow.force(1) == 0.0);
  CHECK(flow.force(2) == 0.0);
}

TEST_CASE("Kang propeller: thrust goes to its limit as the propeller stops", "[forces][propeller]") {
  for (const double u : {-0.3, 0.0, 0.4}) {
    CAPTURE(u);
    const Vec3<double> nu(u, 0.05, 0.02);
    CHECK_THAT(kang().flow(nu, 1e-7).force(0), WithinAbs(kang().flow(nu, 0.0).force(0), 1e-6));
    CHECK(kang().flow(nu, -5.0).force == kang().flow(nu, 0.0).force);
  }
  CHECK(kang().flow({-0.3, 0.0, 0.0}, 0.0).force(0) > 0.0);  // a stopped propeller holds back a ship going astern
}

TEST_CASE("Kang propeller: wake and deduction stay between 0 and 1 for any motion", "[forces][propeller]") {
  for (const double u : {1e-8, 1e-5, 0.01, 0.3, 1.0})
    for (const double v : {-0.3, 0.0, 0.2})
      for (const double r : {-0.3, 0.0, 0.1})
        for (const double n : {0.0, 0.1, 10.0}) {
          const PropellerFlow<double> flow = kang().flow({u, v, r}, n);
          CHECK(flow.one_minus_w_P >= 0.0);
          CHECK(flow.one_minus_w_P <= 1.0);
          CHECK(flow.force.allFinite());
        }
}

TEST_CASE("Kang propeller: the sway velocity is taken at the bow or at the propeller, as asked",
          "[forces][propeller]") {
  // v - x_P r L with x_P < 0 at the bow; turning the other way makes it the velocity at the propeller.
  const Vec3<double> nu(0.4, 0.03, 0.02), other(0.4, 0.03, -0.02);
  CHECK(kang(-1.0).flow(nu, 10.0).force == kang(1.0).flow(other, 10.0).force);
  CHECK(kang(-1.0).flow(nu, 10.0).force != kang(1.0).flow(nu, 10.0).force);
}

TEST_CASE("four-quadrant propeller: its branches join where the fits do", "[forces][propeller]") {
  const FourQuadrantPropeller<double> propeller = four_quadrant();
  const double D = 0.084;
  // Reversed: the side force changes its form at J_s = -0.35 and -0.06, the thrust at -0.233 (within the fit's digits).
  for (const double J_s : {-0.35, -0.06, -0.233}) {
    const double n = -12.0, u = J_s * n * D, du = 1e-9;
    const Vec3<double> below = propeller.flow({u + du, 0.0, 0.0}, n).force;
    const Vec3<double> above = propeller.flow({u - du, 0.0, 0.0}, n).force;
    CAPTURE(J_s);
    CHECK_THAT(above(0), WithinAbs(below(0), 0.01 * std::abs(below(0))));
    CHECK_THAT(above(1), WithinAbs(below(1), 1e-3 * 998.0 * 3.0 * 0.2 * 0.5 * D * D * n * n * 0.003));
    CHECK_THAT(above(2), WithinAbs(below(2), 1e-2 * std::abs(below(2)) + 1e-3));
  }
}

TEST_CASE("four-quadrant propeller: every quadrant is finite and pushes the right way", "[forces][propeller]") {
  const FourQuadrantPropeller<double> propeller = four_quadrant();
  for (const double u : {-0.3, -1e-8, 0.0, 1e-8, 0.4})
    for (const double n : {-20.0, -1e-9, 0.0, 1e-9, 15.0}) {
      CAPTURE(u, n);
      CHECK(propeller.flow({u, 0.02, -0.03}, n).force.allFinite());
    }
  CHECK(propeller.flow({0.2, 0.0, 0.0}, 15.0).force(0) > 0.0);
  CHECK(propeller.flow({0.2, 0.0, 0.0}, -15.0).force(0) < 0.0);
  CHECK(propeller.flow({0.2, 0.0, 0.0}, 15.0).force(1) == 0.0);
  CHECK(propeller.flow({0.2, 0.0, 0.0}, -15.0).force(2) > 0.0);  // a reversed right-handed screw turns the bow right
  CHECK(propeller.flow({-0.2, 0.0, 0.0}, 15.0).force(1) > 0.0);
}

TEST_CASE("four-quadrant propeller: thrust reversed at rest is the table's", "[forces][propeller]") {
  const double n = -10.0, D = 0.084;
  const Vec3<double> force = four_quadrant().flow(Vec3<double>::Zero(), n).force;
  CHECK_THAT(force(0), WithinRel(-0.175 * 998.0 * n * n * std::pow(D, 4), 1e-12));
  CHECK_THAT(force(1), WithinRel(-0.000558 * 0.5 * 998.0 * 3.0 * 0.20114 * n * n * D * D, 1e-12));
}
