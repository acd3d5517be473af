#include "estimate/regressions.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "core/units.hpp"

using namespace leeway;
using namespace leeway::estimate;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

// KVLCC2: C_b, L/B, B/d, L/d, x_G, m.
const HullForm kTanker{0.81, 320.0 / 58.0, 58.0 / 20.8, 320.0 / 20.8, 0.035, 2.0 * 0.81 * 58.0 / 320.0};

}  // namespace

TEST_CASE("regressions: KVLCC2 by hand", "[estimate][regressions]") {
  // k = 0.13, c = 0.1468125
  const LinearDerivatives kijima = linear_by_kijima(kTanker, 0.022);
  CHECK_THAT(kijima.Y_v, WithinAbs(-(0.5 * kPi * 0.13 + 1.4 * 0.1468125), 1e-12));
  CHECK_THAT(kijima.N_v, WithinAbs(-0.13, 1e-12));
  CHECK_THAT(kijima.N_r, WithinAbs(-0.0533, 1e-12));
  CHECK_THAT(kijima.Y_r, WithinAbs(0.022 + 0.07340625, 1e-12));
  const LinearDerivatives clarke = linear_by_clarke(kTanker);
  CHECK_THAT(clarke.Y_v, WithinAbs(-0.3887, 2e-4));
  CHECK_THAT(clarke.Y_r, WithinAbs(0.0662, 2e-4));
  CHECK_THAT(clarke.N_v, WithinAbs(-0.1340, 2e-4));
  CHECK_THAT(clarke.N_r, WithinAbs(-0.0525, 2e-4));
  const LinearDerivatives lee = linear_by_lee(kTanker, 0.022);
  CHECK_THAT(lee.Y_v, WithinAbs(-0.3077, 2e-4));
  CHECK_THAT(lee.N_v, WithinAbs(-0.1392, 2e-4));
  CHECK_THAT(lee.N_r, WithinAbs(-0.0434, 2e-4));
}

TEST_CASE("regressions: added mass of KVLCC2 is that of the published table", "[estimate][regressions]") {
  CHECK_THAT(m_y_by_zhou(kTanker), WithinRel(0.223, 0.02));
  CHECK_THAT(J_z_by_zhou(kTanker), WithinRel(0.011, 0.05));
  CHECK_THAT(m_y_by_clarke(kTanker), WithinRel(0.223, 0.15));
  CHECK_THAT(J_z_by_clarke(kTanker), WithinRel(0.011, 0.20));
}

TEST_CASE("regressions: a larger ship of the same form has the same coefficients", "[estimate][regressions]") {
  // Nothing but ratios goes in; what remains to check is that mass and added mass keep their signs over ship forms.
  for (const double C_b : {0.5, 0.6, 0.7, 0.8})
    for (const double L_by_B : {5.0, 6.0, 7.0})
      for (const double B_by_d : {2.2, 3.0, 4.0}) {
        const HullForm h{C_b, L_by_B, B_by_d, L_by_B * B_by_d, 0.0, 2.0 * C_b / L_by_B};
        CAPTURE(C_b, L_by_B, B_by_d);
        for (const LinearDerivatives& d : {linear_by_kijima(h, 0.01), linear_by_clarke(h), linear_by_lee(h, 0.01)}) {
          CHECK(d.Y_v < 0.0);
          CHECK(d.N_v < 0.0);
          CHECK(d.N_r < 0.0);
        }
        CHECK(m_y_by_zhou(h) > 0.0);
        CHECK(m_y_by_clarke(h) > 0.0);
        CHECK(J_z_by_zhou(h) > 0.0);
        CHECK(J_z_by_clarke(h) > 0.0);
        CHECK(m_x_by_soeding(h) > 0.0);
      }
}

TEST_CASE("regressions: the normal force of a rudder by Fujii", "[estimate][regressions]") {
  CHECK_THAT(f_alpha_by_fujii(1.539), WithinAbs(2.48986, 1e-5));  // of the Esso Osaka's published set
}
