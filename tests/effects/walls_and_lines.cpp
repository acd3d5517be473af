#include <catch2/catch.hpp>
#include <ceres/jet.h>

#include "dynamics/model_parts.hpp"
#include "effects/effect_runs.hpp"
#include "forces/registry.hpp"

using namespace leeway;
using namespace leeway::test;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr double kL = 3.0, kB = 0.4843, kDraft = 0.1721, kRho = 998.0;  // vectwin-3m
const Vec2<double> kPlace(12.0, -7.0);                                  // of at_heading()

// A wall at this distance from the ship of at_heading(), in this direction.
Parameters wall(double from_ship, double direction_deg) {
  const double along = kPlace(0) * std::cos(direction_deg * kDegree) + kPlace(1) * std::sin(direction_deg * kDegree);
  return {{"wall_distance_m", from_ship + along}, {"wall_direction_deg", direction_deg}};
}

Parameters operator+(Parameters a, const Parameters& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Vec3<double> force_at(const std::string& type, const Parameters& parameters, double psi_deg, const Vec3<double>& nu) {
  Situation<double> at = at_heading(psi_deg);
  at.nu_ground = at.nu_water = nu;
  return Effects<double>(with(read_ship("vectwin-3m"), type, parameters)).force(at);
}

Vec3<double> bank(double from_ship, double direction_deg, double psi_deg, double u, double n = 2.0) {
  return force_at("bank", wall(from_ship, direction_deg) + Parameters{{"C_Y", 0.06}, {"C_N", 0.013}, {"n", n}}, psi_deg,
                  {u, 0.03, -0.01});
}

Vec3<double> fender(double from_ship, double direction_deg, double psi_deg, const Vec3<double>& nu,
                    double damping = 0.0) {
  return force_at("fender",
                  wall(from_ship, direction_deg) + Parameters{{"stiffness_npm", 150.0}, {"damping_spm", damping}},
                  psi_deg, nu);
}

}  // namespace

TEST_CASE("bank: suction towards the wall and the bow away from it, by the formula", "[effects]") {
  // Heading north, a wall to the east: to starboard, 1.5 m off.
  const double gap = 1.5 - kB / 2.0, D = kB / 2.0 + 0.5 * (gap + std::sqrt(gap * gap + kB * kB / 400.0));
  const double f = std::pow(kB / (2.0 * D), 2.0), q = 0.5 * kRho * kL * kDraft * 0.16;
  const Vec3<double> starboard = bank(1.5, 90.0, 0.0, 0.4);
  CHECK(starboard(0) == 0.0);
  CHECK_THAT(starboard(1), WithinRel(q * 0.06 * f, 1e-12));
  CHECK_THAT(starboard(2), WithinRel(-q * kL * 0.013 * f, 1e-12));
  CHECK_THAT(f, WithinRel(std::pow(kB / 3.0, 2.0), 2e-3));  // (B/2D)^n but for the limit near the hull

  // Mirrored to port; the compass course does not matter.
  const Vec3<double> port = bank(1.5, 270.0, 0.0, 0.4), turned = bank(1.5, 167.0, 77.0, 0.4);
  CHECK_THAT(port(1), WithinRel(-starboard(1), 1e-12));
  CHECK_THAT(port(2), WithinRel(-starboard(2), 1e-12));
  CHECK_THAT(turned(1), WithinRel(starboard(1), 1e-12));
  // Half of it where the wall's direction is 30 deg from the bow, none head on.
  CHECK_THAT(bank(1.5, 30.0, 0.0, 0.4)(1), WithinRel(0.5 * starboard(1), 1e-12));
  CHECK_THAT(bank(1.5, 0.0, 0.0, 0.4)(1), WithinAbs(0.0, 1e-12));
}

TEST_CASE("bank: square of the speed, power of the distance; astern the moment turns and the suction stays",
          "[effects]") {
  const Vec3<double> ahead = bank(1.5, 90.0, 0.0, 0.4), fast = bank(1.5, 90.0, 0.0, 0.8);
  const Vec3<double> astern = bank(1.5, 90.0, 0.0, -0.4);
  for (int i = 1; i < 3; ++i) CHECK_THAT(fast(i), WithinRel(4.0 * ahead(i), 1e-12));
  CHECK_THAT(astern(1), WithinRel(ahead(1), 1e-12));
  CHECK_THAT(astern(2), WithinRel(-ahead(2), 1e-12));
  CHECK(bank(1.5, 90.0, 0.0, 0.0).isZero());
  for (const double n : {1.0, 3.0})
    CHECK_THAT(bank(20.0, 90.0, 0.0, 0.4, n)(1) / bank(10.0, 90.0, 0.0, 0.4, n)(1), WithinRel(std::pow(0.5, n), 1e-4));
}

TEST_CASE("bank: it looks at the speed through the water", "[effects]") {
  const Effects<double> effects(
      with(read_ship("vectwin-3m"), "bank", wall(1.5, 90.0) + Parameters{{"C_Y", 0.06}, {"C_N", 0.013}}));
  Situation<double> at = at_heading(0.0);
  const Vec3<double> still = effects.force(at);
  at.nu_ground(0) += 0.3;
  CHECK(effects.force(at) == still);
  at.nu_water(0) += 0.3;
  CHECK(effects.force(at)(1) > 2.0 * still(1));
}

TEST_CASE("bank: finite and smooth while the centerline passes the wall", "[effects]") {
  using Jet = ceres::Jet<double, 1>;
  const Ship ship = read_ship("vectwin-3m");
  const Bank<Jet> effect({Jet(0.0), Jet(90.0), Jet(0.06), Jet(0.013), Jet(2.0)}, ship);
  Situation<Jet> at;
  at.cos_psi = Jet(1.0);
  at.sin_psi = Jet(0.0);
  at.nu_water = {Jet(0.4), Jet(0.0), Jet(0.0)};
  const double most = 0.5 * kRho * kL * kDraft * 0.16 * 0.06;  // at D = B/2
  double last = 0.0, last_slope = 0.0;
  for (double y = -3.0; y < 3.0; y += 1e-3) {
    at.eta = {Jet(5.0), Jet(y, 0), Jet(0.0)};
    const Jet Y = effect.force(at)(1);
    CHECK(Y.a > last);
    CHECK(Y.a < most);
    if (y > -2.9995) {
      CHECK_THAT(Y.a - last, WithinAbs(0.5e-3 * (Y.v(0) + last_slope), 1e-5 * most));  // the slope has no step
      CHECK(std::abs(Y.v(0) - last_slope) < 0.4 * most);
    }
    last = Y.a;
    last_slope = Y.v(0);
  }
  CHECK(last > 0.99 * most);
}

TEST_CASE("fender: no force before contact, then the stiffness of the corners that touch", "[effects]") {
  const Vec3<double> still = Vec3<double>::Zero();
  CHECK(fender(kB / 2.0 + 1e-6, 90.0, 0.0, {0.5, 0.2, 0.1}).isZero());
  // Alongside to starboard both corners are 4 cm in: 2 x 150 N/m x 0.04 m to port.
  const Vec3<double> alongside = fender(kB / 2.0 - 0.04, 90.0, 0.0, still);
  CHECK_THAT(alongside(0), WithinAbs(0.0, 1e-12));
  CHECK_THAT(alongside(1), WithinRel(-12.0, 1e-12));
  CHECK_THAT(alongside(2), WithinAbs(0.0, 1e-12));
  const Vec3<double> to_port = fender(kB / 2.0 - 0.04, 270.0, 0.0, still);
  CHECK_THAT(to_port(1), WithinRel(12.0, 1e-12));
  // Bow on: X alone. The wall may lie anywhere.
  CHECK_THAT(fender(kL / 2.0 - 0.03, 123.0, 123.0, still)(0), WithinRel(-9.0, 1e-12));

  // 20 deg towards the wall: the starboard bow alone, 1 cm in.
  const double c = std::cos(70.0 * kDegree), s = std::sin(70.0 * kDegree);  // from the bow to the wall's normal
  const double reach = kL / 2.0 * c + kB / 2.0 * s;
  const Vec3<double> bow = fender(reach - 0.01, 90.0, 20.0, still);
  CHECK_THAT(bow(0), WithinRel(-1.5 * c, 1e-9));
  CHECK_THAT(bow(1), WithinRel(-1.5 * s, 1e-9));
  CHECK_THAT(bow(2), WithinRel(-1.5 * (kL / 2.0 * s - kB / 2.0 * c), 1e-9));  // bow away
  const Vec3<double> mirrored = fender(reach - 0.01, -90.0, -20.0, still);
  CHECK_THAT(mirrored(1), WithinRel(-bow(1), 1e-9));
  CHECK_THAT(mirrored(2), WithinRel(-bow(2), 1e-9));
}

TEST_CASE("fender: damping adds on the way in, takes on the way out and never pulls", "[effects]") {
  const auto Y = [&](double v, double r) { return fender(kB / 2.0 - 0.04, 90.0, 0.0, {0.3, v, r}, 4.0)(1); };
  CHECK_THAT(Y(0.1, 0.0), WithinRel(-12.0 * 1.4, 1e-12));
  CHECK_THAT(Y(-0.1, 0.0), WithinRel(-12.0 * 0.6, 1e-12));
  CHECK(Y(-0.3, 0.0) == 0.0);
  // Turning on the spot: the bow goes in with r L/2, the stern comes out as fast, and lets go from 0.25 m/s on.
  CHECK_THAT(Y(0.0, 0.1), WithinRel(-12.0, 1e-12));
  CHECK_THAT(Y(0.0, 0.2), WithinRel(-6.0 * (1.0 + 4.0 * 0.2 * kL / 2.0), 1e-12));
}

TEST_CASE("fender: a ship that drifts on a quay is stopped within what its energy can press in", "[effects]") {
  Ship ship = read_ship("esso-osaka-3m");
  ship.modules->wind.reset();
  const double k = 400.0, v = 0.05, B = ship.particulars.B;
  SimulatedShip simulated(with(ship, "fender",
                               {{"wall_distance_m", B / 2.0 + 0.02},
                                {"wall_direction_deg", 90.0},
                                {"stiffness_npm", k},
                                {"damping_spm", 5.0}}),
                          0.0);
  simulated.state.nu = {0.0, v, 0.0};
  Actuators<double> idle = ship.initial_actuators();
  idle[Channel::n_p] = 0.0;
  simulated.actuators = idle;
  const Inertia<double>& i = simulated.model.parts().inertia;
  const double most = 0.02 + v * std::sqrt((i.m + i.m_y) / (2.0 * k));
  double furthest = 0.0;
  for (int step = 0; step < 1200; ++step) {
    simulated.step(idle, Vec2<double>::Zero(), 0.05);
    furthest = std::max(furthest, simulated.state.eta(1));
  }
  CHECK(furthest > 0.02);
  CHECK(furthest < most);
  CHECK(simulated.state.eta(1) < 0.021);
}

TEST_CASE("mooring: tension beyond the slack towards the anchor, with its lever", "[effects]") {
  // Heading north at (12, -7), attached 1 m ahead and 0.5 m to starboard: 3 m north and 4 m east of there.
  const Parameters line{{"anchor_x_m", 16.0},    {"anchor_y_m", -2.5}, {"stiffness_npm", 2.0},
                        {"slack_length_m", 1.0}, {"attach_x_m", 1.0},  {"attach_y_m", 0.5}};
  const Vec3<double> F = force_of("mooring", line, 0.0);
  CHECK_THAT(F(0), WithinRel(8.0 * 0.6, 1e-12));
  CHECK_THAT(F(1), WithinRel(8.0 * 0.8, 1e-12));
  CHECK_THAT(F(2), WithinRel(1.0 * 6.4 - 0.5 * 4.8, 1e-12));

  // At midship, without slack: stiffness times distance, whatever the heading.
  const Parameters spring{{"anchor_x_m", 15.0}, {"anchor_y_m", -3.0}, {"stiffness_npm", 2.0}};
  const Vec3<double> east = force_of("mooring", spring, 90.0);
  CHECK_THAT(east(0), WithinRel(8.0, 1e-12));
  CHECK_THAT(east(1), WithinRel(-6.0, 1e-12));
  CHECK(east(2) == 0.0);
  CHECK(force_of("mooring", spring + Parameters{{"slack_length_m", 5.01}}, 90.0).isZero());
}

TEST_CASE("mooring: at the anchor its force is zero and its derivative the stiffness", "[effects]") {
  using Jet = ceres::Jet<double, 2>;
  const Mooring<Jet> effect({Jet(4.0), Jet(5.0), Jet(3.0), Jet(0.0), Jet(0.0), Jet(0.0)}, read_ship("esso-osaka-3m"));
  Situation<Jet> at;
  at.cos_psi = Jet(0.6);
  at.sin_psi = Jet(0.8);
  at.eta = {Jet(4.0, 0), Jet(5.0, 1), Jet(0.0)};
  const Vec3<Jet> F = effect.force(at);
  CHECK(F(0).a == 0.0);
  CHECK_THAT(F(0).v(0), WithinRel(-3.0 * 0.6, 1e-12));
  CHECK_THAT(F(1).v(1), WithinRel(-3.0 * 0.6, 1e-12));
  CHECK_THAT(F(1).v(0), WithinRel(3.0 * 0.8, 1e-12));
}

TEST_CASE("tug, body force, earth force: frame, point of action and time", "[effects]") {
  const Parameters tug{{"force_N", 0.8}, {"direction_deg", 90.0}, {"x_m", 1.2},
                       {"y_m", 0.2},     {"t_start_s", 5.0},      {"t_end_s", 9.0}};
  const Vec3<double> pushed = force_of("tug", tug, 77.0);  // at t = 5 s, in ship axes whatever the heading
  CHECK_THAT(pushed(0), WithinAbs(0.0, 1e-15));
  CHECK_THAT(pushed(1), WithinRel(0.8, 1e-12));
  CHECK_THAT(pushed(2), WithinRel(1.2 * 0.8, 1e-12));
  const Vec3<double> ahead = force_of("tug", {{"force_N", 0.8}, {"direction_deg", 0.0}, {"y_m", 0.2}}, 77.0);
  CHECK_THAT(ahead(2), WithinRel(-0.2 * 0.8, 1e-12));  // ahead on the starboard side: bow to port
  const Effects<double> effects(with(read_ship("vectwin-3m"), "tug", tug));
  Situation<double> at = at_heading(0.0);
  for (const auto& [t, is_on] : {std::pair(4.99, false), {5.0, true}, {8.99, true}, {9.0, false}}) {
    at.t_s = t;
    CHECK((effects.force(at).norm() > 0.0) == is_on);
  }
  const Vec3<double> body = force_of("body-force", {{"X_N", 0.1}, {"Y_N", -0.2}, {"N_Nm", 0.3}}, 123.0);
  CHECK(body == Vec3<double>(0.1, -0.2, 0.3));
  // A pull to the east on a ship that heads north comes from starboard; heading east, from ahead.
  const Parameters east{{"force_N", 0.5}, {"direction_deg", 90.0}};
  CHECK_THAT(force_of("earth-force", east, 0.0)(1), WithinRel(0.5, 1e-12));
  CHECK_THAT(force_of("earth-force", east, 90.0)(0), WithinRel(0.5, 1e-12));
  CHECK(force_of("earth-force", east, 33.0)(2) == 0.0);
}
