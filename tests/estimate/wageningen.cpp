#include "estimate/wageningen.hpp"

#include <cmath>

#include <catch2/catch.hpp>

using namespace leeway::estimate;
using Catch::Matchers::WithinAbs;

TEST_CASE("Wageningen B series: the quadratic of a B4-55 that ferry-40m has", "[estimate][wageningen]") {
  // configs/ships/ferry-40m.json: fitted elsewhere, from the same series, within 0.003 for 0 <= J <= 0.95.
  const SeriesPropeller screw{4.0, 0.55, 1.0};
  for (const double J : {0.0, 0.2, 0.4, 0.6, 0.8, 0.95}) {
    CAPTURE(J);
    CHECK_THAT(wageningen_K_T(screw, J), WithinAbs(0.4266 - 0.2548 * J - 0.1348 * J * J, 3.5e-3));
  }
}

TEST_CASE("Wageningen B series: thrust ends near the pitch and grows with it", "[estimate][wageningen]") {
  double last = 0.0;
  for (const double pitch : {0.6, 0.8, 1.0, 1.2}) {
    const SeriesPropeller screw{4.0, 0.6, pitch};
    const double J_0 = wageningen_J_0(screw);
    CAPTURE(pitch, J_0);
    CHECK(J_0 > pitch);
    CHECK(J_0 < pitch + 0.12);
    CHECK_THAT(wageningen_K_T(screw, J_0), WithinAbs(0.0, 1e-9));
    CHECK(wageningen_K_T(screw, 0.0) > last);
    last = wageningen_K_T(screw, 0.0);
    const QuadraticThrust fit = fit_quadratic(screw);
    CHECK(fit.largest_error < 0.012);
    CHECK(fit.K_T[0] > 0.0);
    CHECK(fit.K_T[1] < 0.0);
  }
}
