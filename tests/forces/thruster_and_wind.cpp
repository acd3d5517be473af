#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "core/wind.hpp"
#include "forces/fujiwara_wind.hpp"
#include "forces/registry.hpp"
#include "forces/side_thruster.hpp"
#include "ship/ship.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("bow thruster: check values at rest and at speed", "[forces][thruster]") {
  const Ship ship = read_ship("vectwin-3m");
  const SideThruster<double> thruster(std::get<SideThrusterCoefficients<double>>(ship.modules->thrusters.at(0)),
                                      ship.particulars);
  const auto force = [&](double u, double n) {
    Actuators<double> a;
    a[Channel::n_bt] = n;
    return thruster.force({u, 0.1, 0.02}, a);
  };
  const double ahead = 998.0 * std::pow(0.039, 4) * 900.0 * 0.16684;
  CHECK_THAT(ahead, WithinAbs(0.347, 0.0005));
  CHECK_THAT(force(0.0, 30.0)(1), WithinAbs(0.428, 0.0005));
  CHECK_THAT(force(0.0, 30.0)(1), WithinRel(1.2352 * ahead, 1e-12));
  CHECK_THAT(force(0.0, -30.0)(1) / 1.2352, WithinAbs(-0.460, 0.0005));
  CHECK_THAT(force(0.0, 30.0)(2), WithinRel(1.2231 * ahead * 1.3564, 1e-12));
  const double per_Fr = std::sqrt(kGravity_mps2 * 3.0);
  CHECK_THAT(force(0.0946 * per_Fr, 30.0)(1) / ahead, WithinAbs(0.634, 0.001));
  CHECK_THAT(force(0.0413 * per_Fr, 30.0)(2) / ahead / 1.3564, WithinAbs(1.088, 0.001));
  CHECK(force(0.3, 20.0) == force(-0.3, 20.0));
  CHECK(force(0.651, 30.0).isZero(0.0));
  CHECK(force(0.6509, 30.0)(1) > 0.0);
  CHECK_THAT(force(0.2, 1e-6)(1), WithinAbs(force(0.2, -1e-6)(1), 1e-12));
}

TEST_CASE("side thrusters: the Esso Osaka model's lose force linearly with speed, up to the cut-off",
          "[forces][thruster]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const double Fr_of_1 = 1.0 / std::sqrt(kGravity_mps2 * 3.0), D4 = std::pow(0.05, 4);
  for (const auto& coefficients : ship.modules->thrusters) {
    const auto& c = std::get<SideThrusterCoefficients<double>>(coefficients);
    const SideThruster<double> thruster(c, ship.particulars);
    const bool is_bow = c.channel == Channel::n_bt;
    CHECK((c.x > 0.0) == is_bow);
    for (const double n : {-20.0, 15.0})
      for (const double u : {-0.2, 0.0, 0.1, 0.2476}) {
        Actuators<double> a;
        a[c.channel] = n;
        const double K_T = n > 0.0 ? (is_bow ? 0.360 : 0.17) : (is_bow ? -0.450 : -0.21), Fr = std::abs(u) * Fr_of_1;
        const double T = 998.0 * D4 * n * n * K_T;
        const Vec3<double> force = thruster.force({u, 0.03, -0.02}, a);
        CHECK(force(0) == 0.0);
        CHECK_THAT(force(1), WithinRel((1.0 - (is_bow ? 5.83 : 2.56) * Fr) * T, 1e-12));
        CHECK_THAT(force(2), WithinRel((1.0 - (is_bow ? 3.44 : 7.46) * Fr) * T * (is_bow ? 1.35 : -1.30), 1e-12));
        CHECK(thruster.force({0.24765, 0.0, 0.0}, a).isZero(0.0));  // the step at the cut-off: from 0.65 .. 0.88 of T
      }
  }
}

TEST_CASE("wind: Fujiwara's regression gives the stored coefficients of the Esso Osaka model", "[forces][wind]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const FujiwaraWind<double> wind(std::get<FujiwaraWindGeometry>(*ship.modules->wind), ship.particulars);
  // The constants that public research code holds for this model, to all their digits.
  CHECK_THAT(wind.X0, WithinAbs(-0.010466204999, 1e-12));
  CHECK_THAT(wind.X1, WithinAbs(-0.821991956432, 1e-12));
  CHECK_THAT(wind.X3, WithinAbs(0.060273613257, 1e-12));
  CHECK_THAT(wind.X5, WithinAbs(0.044558221361, 1e-12));
  CHECK_THAT(wind.Y1, WithinAbs(1.058172082517, 1e-12));
  CHECK_THAT(wind.Y3, WithinAbs(0.002321463295, 1e-12));
  CHECK_THAT(wind.Y5, WithinAbs(-0.015293451707, 1e-12));
  CHECK_THAT(wind.N1, WithinAbs(-0.030727798087, 1e-12));
  CHECK_THAT(wind.N2, WithinAbs(0.104116370351, 1e-12));
  CHECK_THAT(wind.N3, WithinAbs(-0.000880301476, 1e-12));
  const auto at = [&](double deg) { return wind.coefficients(std::cos(deg * kDegree), std::sin(deg * kDegree)); };
  CHECK_THAT(at(0.0)(0), WithinAbs(-0.7276, 5e-5));
  CHECK_THAT(at(90.0)(1), WithinAbs(-1.0406, 5e-5));
  CHECK_THAT(at(30.0)(2), WithinAbs(-0.0739, 5e-5));
  CHECK_THAT(at(90.0)(2), WithinAbs(0.0299, 6e-5));
  CHECK_THAT(at(150.0)(2), WithinAbs(0.1064, 5e-5));
}

TEST_CASE("wind: it pushes with the wind, in mirror symmetry, and not in calm", "[forces][wind]") {
  const Ship ship = read_ship("vectwin-3m");
  const FujiwaraWind<double> wind(std::get<FujiwaraWindGeometry>(*ship.modules->wind), ship.particulars);
  CHECK(wind.force({0.0, 0.0}).isZero(0.0));
  CHECK(wind.force({2.0, 0.0})(0) < 0.0);
  CHECK(wind.force({-2.0, 0.0})(0) > 0.0);
  CHECK(wind.force({0.0, 2.0})(1) < 0.0);
  const Vec3<double> starboard = wind.force({0.7, 1.6}), port = wind.force({0.7, -1.6});
  CHECK_THAT(port(0), WithinRel(starboard(0), 1e-14));
  CHECK_THAT(port(1), WithinRel(-starboard(1), 1e-14));
  CHECK_THAT(port(2), WithinRel(-starboard(2), 1e-14));
  CHECK_THAT(wind.force({1.4, 3.2})(1), WithinRel(4.0 * starboard(1), 1e-14));
}

TEST_CASE("wind: a ship going ahead in calm air feels it from the bow", "[forces][wind]") {
  const Vec2<double> apparent = apparent_wind<double>({0.0, 0.0}, 1.1, 0.7, 0.0);
  CHECK(apparent(0) == 0.7);
  CHECK(apparent(1) == 0.0);
}
