#include "estimate/holtrop.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "core/units.hpp"

using namespace leeway;
using namespace leeway::estimate;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

// The ship of the worked example in Holtrop & Mennen (1982), section 5: 25 kn.
HoltropHull printed_example() {
  HoltropHull h;
  h.L = 205.0;
  h.B = 32.0;
  h.T_F = h.T_A = 10.0;
  h.volume = 37500.0;
  h.lcb = -0.75;
  h.C_M = 0.98;
  h.C_WP = 0.75;
  h.A_BT = 20.0;
  h.h_B = 4.0;
  h.A_T = 16.0;
  h.C_stern = 10.0;
  h.rho = 1025.0;
  h.nu = 1.18831e-6;
  return h;
}

}  // namespace

TEST_CASE("Holtrop and Mennen: the worked example of 1982 as it is printed", "[estimate][holtrop]") {
  const HoltropHull h = printed_example();
  const double U = 25.0 * kKnot;
  const HoltropResistance r = holtrop_resistance(h, U);
  CHECK_THAT(h.C_P(), WithinAbs(0.5833, 5e-5));
  CHECK_THAT(holtrop_wetted_surface(h), WithinRel(7381.45, 1e-4));
  CHECK_THAT(r.form_factor, WithinAbs(1.156, 1e-3));
  CHECK_THAT(r.C_F, WithinAbs(0.001390, 2e-6));
  CHECK_THAT(r.R_F, WithinRel(869.63e3, 3e-3));
  CHECK_THAT(holtrop_entrance(h), WithinAbs(12.08, 0.02));
  CHECK_THAT(r.R_W, WithinRel(557.11e3, 1e-2));
  CHECK_THAT(r.R_B, WithinAbs(49.0, 2.0));
  CHECK_THAT(r.C_A, WithinAbs(0.000352, 2e-6));
  CHECK_THAT(holtrop_wake(h, U, 8.0), WithinAbs(0.2584, 1e-2));  // the example adds the appendages to C_V
  CHECK_THAT(holtrop_thrust_deduction(h, 8.0), WithinAbs(0.1747, 5e-4));
}

TEST_CASE("Holtrop and Mennen: more speed, more resistance; a model has no allowance", "[estimate][holtrop]") {
  HoltropHull h = printed_example();
  double last = 0.0;
  for (const double U : {3.0, 6.0, 9.0, 12.0}) {
    const double total = holtrop_resistance(h, U).total;
    CHECK(total > last);
    last = total;
  }
  h.has_allowance = false;
  CHECK(holtrop_resistance(h, 12.0).R_A == 0.0);
  CHECK(holtrop_resistance(h, 12.0).total < last);
}

TEST_CASE("Holtrop and Mennen: a hull fuller than all data has a value and says what is held", "[estimate][holtrop]") {
  HoltropHull h = printed_example();
  CHECK(holtrop_limits(h).empty());
  for (const double C_b : {0.89, 0.93, 0.98}) {
    CAPTURE(C_b);
    h.volume = C_b * h.L * h.B * h.T();
    h.C_M = 0.998;
    h.lcb = 4.0;
    h.C_WP = (1.0 + 2.0 * C_b) / 3.0;
    REQUIRE_FALSE(holtrop_limits(h).empty());
    CHECK(holtrop_limits(h)[0].find("C_b of 0.") != std::string::npos);
    CHECK(holtrop_resistance(h, 6.0).total > 0.0);
    CHECK(std::isfinite(holtrop_wake(h, 6.0, 6.0)));
    CHECK(std::isfinite(holtrop_thrust_deduction(h, 6.0)));
  }
}

TEST_CASE("ITTC 1957: the printed line", "[estimate][holtrop]") {
  CHECK_THAT(ittc_57(1e6), WithinRel(4.6875e-3, 1e-9));
  CHECK_THAT(ittc_57(1e9), WithinRel(1.5306e-3, 1e-4));
}
