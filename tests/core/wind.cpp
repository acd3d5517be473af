#include "core/wind.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "core/units.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

// Direction that a from-vector in ship axes comes from, 0 from the bow, positive from starboard.
double gamma_A(const Vec2<double>& apparent) { return std::atan2(apparent(1), apparent(0)); }

}  // namespace

TEST_CASE("wind: a ship going ahead in calm air feels its own speed from the bow", "[core][wind]") {
  const Vec2<double> calm = wind_from_vector(0.0, 1.3);
  for (const double psi : {-2.0, 0.0, 0.7, 4.0}) {
    const Vec2<double> apparent = apparent_wind(calm, psi, 0.8, 0.0);
    CHECK_THAT(gamma_A(apparent), WithinAbs(0.0, 1e-15));
    CHECK_THAT(apparent.norm(), WithinRel(0.8, 1e-15));
  }
  // Drifting to starboard in calm air: the wind comes from starboard.
  CHECK_THAT(gamma_A(apparent_wind(calm, 0.7, 0.0, 0.3)), WithinRel(kPi / 2.0, 1e-15));
}

TEST_CASE("wind: a ship at rest feels the true wind from its direction less the heading", "[core][wind]") {
  const double xi_T = deg_to_rad(75.0), psi = deg_to_rad(30.0);
  const Vec2<double> apparent = apparent_wind(wind_from_vector(6.0, xi_T), psi, 0.0, 0.0);
  CHECK_THAT(rad_to_deg(gamma_A(apparent)), WithinRel(45.0, 1e-14));
  CHECK_THAT(apparent.norm(), WithinRel(6.0, 1e-15));
}

TEST_CASE("wind: running with the wind lessens it, running against it adds to it", "[core][wind]") {
  // The wind blows from +x0 to -x0; psi = 0 goes against it.
  const Vec2<double> wind = wind_from_vector(5.0, 0.0);
  CHECK_THAT(apparent_wind(wind, 0.0, 2.0, 0.0).norm(), WithinRel(7.0, 1e-15));
  CHECK_THAT(apparent_wind(wind, kPi, 2.0, 0.0).norm(), WithinRel(3.0, 1e-14));
}

TEST_CASE("wind: the true wind comes back from the apparent one", "[core][wind]") {
  for (const double psi : {-2.6, 0.4, 9.1})
    for (const double v_m : {-0.4, 0.2}) {
      const Vec2<double> wind = wind_from_vector(3.3, -1.9);
      const Vec2<double> back = true_wind_from_apparent(apparent_wind(wind, psi, 1.1, v_m), psi, 1.1, v_m);
      CHECK_THAT((back - wind).norm(), WithinAbs(0.0, 1e-14));
    }
}
