#include <catch2/catch.hpp>

#include "dynamics/model_parts.hpp"
#include "effects/effect_runs.hpp"

using namespace leeway;
using namespace leeway::test;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

// What ice does to the vectwin-150m at this speed over ground, other parameters by default.
Vec3<double> ice(double thickness_m, double u, const Parameters& others = {}) {
  Parameters parameters{{"ice_thickness_m", thickness_m}};
  parameters.insert(parameters.end(), others.begin(), others.end());
  Situation<double> at = at_heading(20.0);
  at.nu_ground = at.nu_water = {u, 0.3, 0.01};
  return Effects<double>(with(read_ship("vectwin-150m"), "level-ice", parameters)).force(at);
}

}  // namespace

TEST_CASE("level ice: resistance of crushing, bending and submerging by the printed formula", "[effects]") {
  const double h = 0.8, u = 3.0, L = 150.0, B = 24.215, d = 8.605, rho = 1025.0, g = kGravity_mps2, mu = 0.12;
  const double phi = 25.0 * kDegree, alpha = 35.0 * kDegree, sigma = 4e5, E = 1.7e9;
  const double psi = std::atan(std::tan(phi) / std::sin(alpha));
  const double R_c = 0.5 * sigma * h * h * (std::tan(phi) + mu * std::cos(phi) / std::cos(psi)) /
                     (1.0 - mu * std::sin(phi) / std::cos(psi));
  const double R_b = 27.0 / 64.0 * sigma * B * std::pow(h, 1.5) / std::sqrt(E / (12.0 * (1.0 - 0.09) * g * rho)) *
                     (std::tan(psi) + mu * std::cos(phi) / (std::sin(alpha) * std::cos(psi))) *
                     (1.0 + 1.0 / std::cos(psi));
  const double R_s =
      (rho - 900.0) * g * h * B *
      (d * (B + d) / (B + 2.0 * d) + mu * (0.7 * L - d / std::tan(phi) - B / (4.0 * std::tan(alpha)) +
                                           d * std::cos(phi) * std::cos(psi) *
                                               std::sqrt(std::pow(std::sin(phi), -2) + std::pow(std::tan(alpha), -2))));
  const double R = (R_c + R_b) * (1.0 + 1.4 * u / std::sqrt(g * h)) + R_s * (1.0 + 9.4 * u / std::sqrt(g * L));
  const double faded = u / std::hypot(u, 0.005 * std::sqrt(g * L));
  const Vec3<double> force = ice(h, u,
                                 {{"flexural_strength_pa", sigma},
                                  {"elastic_modulus_pa", E},
                                  {"friction", mu},
                                  {"stem_angle_deg", 25.0},
                                  {"entrance_angle_deg", 35.0}});
  CHECK_THAT(force(0), WithinRel(-R * faded, 1e-12));
  CHECK(force(1) == 0.0);
  CHECK(force(2) == 0.0);
}

TEST_CASE("level ice: sign, size and growth", "[effects]") {
  // 0.8 m of ice holds such a ship back by about 1 MN at 3 m/s: about what icebreakers of this beam are built for.
  CHECK(ice(0.8, 3.0)(0) < -0.5e6);
  CHECK(ice(0.8, 3.0)(0) > -2e6);
  CHECK_THAT(ice(0.8, -3.0)(0), WithinRel(-ice(0.8, 3.0)(0), 1e-12));  // against the motion, astern as ahead
  // More than linear in the thickness (submerging), less than its square (crushing).
  const double twice = ice(0.8, 3.0)(0) / ice(0.4, 3.0)(0);
  CHECK(twice > 2.0);
  CHECK(twice < 4.0);
  // Above fading it grows linearly with speed, from a part that does not vanish with it.
  const auto R = [](double u) { return -ice(0.8, u)(0) * std::hypot(u, 0.005 * std::sqrt(kGravity_mps2 * 150.0)) / u; };
  CHECK_THAT(R(6.0) - R(4.0), WithinRel(R(4.0) - R(2.0), 1e-9));
  CHECK(2.0 * R(2.0) - R(4.0) > 0.25e6);
}

TEST_CASE("level ice: nothing without ice or at rest, and no step between", "[effects]") {
  CHECK(ice(0.0, 3.0) == Vec3<double>::Zero());
  CHECK(ice(0.8, 0.0) == Vec3<double>::Zero());
  CHECK_THAT(ice(1e-9, 3.0)(0), WithinAbs(0.0, 0.01));
  for (const double u : {1e-3, 0.05, 0.2}) {
    const double h = 1e-6;
    const double slope = (ice(0.8, u + h)(0) - ice(0.8, u - h)(0)) / (2.0 * h);
    CAPTURE(u);
    CHECK(slope < 0.0);
    CHECK(slope > -6e5 / (0.005 * std::sqrt(kGravity_mps2 * 150.0)) * 1.1);  // R at rest by u_s
  }
}

TEST_CASE("level ice: a ship at constant revolutions slows down, and a steep bow is refused", "[effects]") {
  const Ship ship = read_ship("kvlcc2-l7");
  const Ship iced =
      with(ship, "level-ice", {{"ice_thickness_m", 0.01}, {"flexural_strength_pa", 2e4}, {"elastic_modulus_pa", 8e7}});
  const Vec3<double> nu(1.0, 0.0, 0.0);
  const Actuators<double> actuators = esso_actuators(0.0, 10.0);
  const double without = acceleration(ship, nu, actuators)(0), in_ice = acceleration(iced, nu, actuators)(0);
  CHECK(in_ice < without - 1e-4);
  CHECK_THROWS_WITH(Effects<double>(with(ship, "level-ice", {{"ice_thickness_m", 0.01}, {"stem_angle_deg", 80.0}})),
                    Contains("the stem is too steep"));
}
