#include <catch2/catch.hpp>

#include "core/wind.hpp"
#include "effects/effect_runs.hpp"

using namespace leeway;
using namespace leeway::test;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr double kVxByX = 0.011, kVxByY = -0.007, kVyByX = 0.018, kVyByY = 0.004;  // gradients [1/s], all different

Ship sheared(const Ship& ship, double a, double b, double c, double d, double speed = 0.0, double set_deg = 0.0) {
  return with(ship, "sheared-current",
              {{"dVx_dx_1ps", a},
               {"dVx_dy_1ps", b},
               {"dVy_dx_1ps", c},
               {"dVy_dy_1ps", d},
               {"current_speed_mps", speed},
               {"current_set_deg", set_deg}});
}

Situation<double> at_pose(double x, double y, double psi) {
  Situation<double> at = at_heading(psi / kDegree);
  at.eta = {x, y, psi};
  return at;
}

}  // namespace

TEST_CASE("sheared current: without gradients it is the steady current, to the last bit", "[effects]") {
  for (const char* name : {"vectwin-3m", "kvlcc2-l7"}) {
    const Ship ship = read_ship(name);
    check_same_bits(run(sheared(ship, 0.0, 0.0, 0.0, 0.0, 0.13, 217.0)),
                    run(with(ship, "steady-current", {{"current_speed_mps", 0.13}, {"current_set_deg", 217.0}})));
  }
}

TEST_CASE("sheared current: velocity by place, and the cross flow along the hull as a yaw rate", "[effects]") {
  const Effects<double> effects(sheared(read_ship("esso-osaka-3m"), kVxByX, kVxByY, kVyByX, kVyByY, 0.2, 90.0));
  const double x = 3.0, y = -5.0, psi = 0.9, c = std::cos(psi), s = std::sin(psi);
  const Situation<double> at = at_pose(x, y, psi);
  const WaterMotion<double> water = effects.water(at);
  CHECK_THAT(water.velocity(0), WithinAbs(kVxByX * x + kVxByY * y, 1e-15));
  CHECK_THAT(water.velocity(1), WithinAbs(0.2 + kVyByX * x + kVyByY * y, 1e-15));
  // d v_c/dx in ship axes, from two places on the centerline.
  const auto cross_flow = [&](double ahead) {
    const Vec2<double> V = effects.water(at_pose(x + ahead * c, y + ahead * s, psi)).velocity;
    return -s * V(0) + c * V(1);
  };
  CHECK_THAT(water.turn(at), WithinRel(cross_flow(0.5) - cross_flow(-0.5), 1e-12));

  // Mirrored about the x0 axis, port becomes starboard.
  const Effects<double> mirror(sheared(read_ship("esso-osaka-3m"), kVxByX, -kVxByY, -kVyByX, kVyByY, 0.2, -90.0));
  const Situation<double> there = at_pose(x, -y, -psi);
  const WaterMotion<double> mirrored = mirror.water(there);
  CHECK_THAT(mirrored.velocity(0), WithinAbs(water.velocity(0), 1e-15));
  CHECK_THAT(mirrored.velocity(1), WithinAbs(-water.velocity(1), 1e-15));
  CHECK_THAT(mirrored.turn(there), WithinRel(-water.turn(at), 1e-12));
}

TEST_CASE("sheared current: a ship that turns with water that turns as a solid body feels no hydrodynamic force",
          "[effects]") {
  const double Omega = 0.03;
  for (const char* name : {"esso-osaka-3m", "kvlcc2-l7"}) {
    const Ship ship = read_ship(name);
    const Model<double> model(sheared(ship, 0.0, -Omega, Omega, 0.0));
    for (const double psi : {0.0, 0.8, 4.0}) {
      CAPTURE(name, psi);
      CHECK_THAT(model.effects.water(at_pose(2.0, 1.0, psi)).turn(at_pose(2.0, 1.0, psi)), WithinRel(Omega, 1e-12));
      // At the center, where the water does not move: what is left is the centrifugal force on the center of gravity.
      const Inputs<double> idle{Actuators<double>(), Vec2<double>::Zero(), 0.0};
      const Vec3<double> rate = rate_of_change(model, {{0.0, 0.0, psi}, {0.0, 0.0, Omega}}, idle).nu;
      const Inertia<double>& i = model.inertia;
      CHECK_THAT(rate(0), WithinRel(i.m * i.x_G * Omega * Omega / (i.m + i.m_x), 1e-12));
      CHECK_THAT(rate(1), WithinAbs(0.0, 1e-15));
      CHECK_THAT(rate(2), WithinAbs(0.0, 1e-15));
      // Water at rest damps the same turn.
      CHECK(rate_of_change(Model<double>(ship), {{0.0, 0.0, psi}, {0.0, 0.0, Omega}}, idle).nu(2) < -1e-6);
    }
  }
}

TEST_CASE("sheared current: the equations over ground with dV/dt along the ship's path hold", "[effects]") {
  Ship ship = read_ship("esso-osaka-3m");
  ship.wind.reset();
  const Model<double> model(sheared(ship, kVxByX, kVxByY, kVyByX, kVyByY, 0.15, 30.0));
  const double h = 1e-4;
  const Vec3<double> eta(3.0, -5.0, 0.9), nu(0.45, -0.08, 0.05);
  const Inputs<double> inputs{esso_actuators(12.0, 11.0), Vec2<double>::Zero(), 0.0};
  const Vec3<double> ahead = integrate(model, {eta, nu}, {inputs, inputs, inputs}, h).nu;
  const Vec3<double> back = integrate(model, {eta, nu}, {inputs, inputs, inputs}, -h).nu;
  const Vec3<double> rate = (ahead - back) / (2.0 * h);

  // All by hand: V, its change along the path, and the cross flow's along the hull.
  const double c = std::cos(eta(2)), s = std::sin(eta(2));
  const auto V = [&](double x, double y) -> Vec2<double> {
    return {0.15 * std::cos(30.0 * kDegree) + kVxByX * x + kVxByY * y,
            0.15 * std::sin(30.0 * kDegree) + kVyByX * x + kVyByY * y};
  };
  const auto to_ship = [&](const Vec2<double>& w) -> Vec2<double> {
    return {c * w(0) + s * w(1), c * w(1) - s * w(0)};
  };
  const Vec2<double> path(nu(0) * c - nu(1) * s, nu(0) * s + nu(1) * c);
  const Vec2<double> nu_c = to_ship(V(eta(0), eta(1)));
  const Vec2<double> a = to_ship(V(eta(0) + path(0), eta(1) + path(1)) - V(eta(0), eta(1)));
  const double g = to_ship(V(eta(0) + c, eta(1) + s) - V(eta(0), eta(1)))(1);
  const Vec3<double> nu_r(nu(0) - nu_c(0), nu(1) - nu_c(1), nu(2));
  const Vec3<double> F = model.modules.force({nu_r(0), nu_r(1), nu(2) - g}, inputs.actuators, Vec2<double>::Zero());
  CHECK(std::abs(g) > 5e-3);
  CHECK(a.norm() > 5e-3);
  check_moving_water(model.inertia, nu, rate, nu_c, a, F);
}

TEST_CASE("sheared current: it adds to another current, whose velocity carries the ship through the shear",
          "[effects]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const Parameters current{{"current_speed_mps", 0.12}, {"current_set_deg", 70.0}};
  const Trajectory both = run(sheared(with(ship, "steady-current", current), kVxByX, kVxByY, kVyByX, kVyByY));
  const Trajectory one = run(sheared(ship, kVxByX, kVxByY, kVyByX, kVyByY, 0.12, 70.0));
  for (const Channel channel : {Channel::u, Channel::vm, Channel::r, Channel::x0, Channel::y0})
    CHECK(largest_difference(both, one, channel) < 1e-10);
}

TEST_CASE("anemometer: the model gets the actual wind from what a faulty anemometer recorded", "[effects]") {
  const Ship ship = read_ship("vectwin-3m");
  const Ship faulty = with(ship, "anemometer", {{"anemometer_scale", 1.1}, {"anemometer_angle_deg", 7.0}});
  const Vec2<double> actual = wind_from_vector(1.3, 2.1);
  const Vec3<double> nu(0.4, 0.05, 0.02);
  const Actuators<double> actuators = ship.initial_actuators();
  for (const double psi : {0.0, 1.2, -2.5}) {
    // The anemometer reads 10 % too much and 7 deg too far clockwise; with heading and velocity that makes a true wind.
    const Vec2<double> felt = apparent_wind(actual, psi, nu(0), nu(1));
    const double speed = 1.1 * felt.norm(), direction = std::atan2(felt(1), felt(0)) + 7.0 * kDegree;
    const Vec2<double> recorded = true_wind_from_apparent(wind_from_vector(speed, direction), psi, nu(0), nu(1));
    const auto rate = [&](const Ship& s, const Vec2<double>& wind) {
      return rate_of_change(Model<double>(s), {{1.0, 2.0, psi}, nu}, Inputs<double>{actuators, wind, 0.0}).nu;
    };
    const Vec3<double> expected = rate(ship, actual), got = rate(faulty, recorded), wrong = rate(ship, recorded);
    for (int i = 0; i < 3; ++i) CHECK_THAT(got(i), WithinAbs(expected(i), 1e-14));
    CHECK((wrong - expected).norm() > 1e-5);
  }
}

TEST_CASE("anemometer: signs, and no correction without a recorded wind", "[effects]") {
  Situation<double> at = at_heading(0.0);
  at.nu_ground = at.nu_water = Vec3<double>::Zero();
  const auto correction = [&](double scale, double angle_deg) {
    return Effects<double>(with(read_ship("vectwin-3m"), "anemometer",
                                {{"anemometer_scale", scale}, {"anemometer_angle_deg", angle_deg}}))
        .wind(at);
  };
  at.recorded_wind = {2.2, 0.0};  // from ahead, read 10 % too high: 2 m/s
  CHECK_THAT(correction(1.1, 0.0)(0), WithinAbs(-0.2, 1e-14));
  CHECK_THAT(correction(1.1, 0.0)(1), WithinAbs(0.0, 1e-14));
  at.recorded_wind = wind_from_vector(2.0, 10.0 * kDegree);  // read 10 deg too far to starboard: from ahead
  const Vec2<double> actual = at.recorded_wind + correction(1.0, 10.0);
  CHECK_THAT(actual(0), WithinAbs(2.0, 1e-14));
  CHECK_THAT(actual(1), WithinAbs(0.0, 1e-14));
  at.recorded_wind = Vec2<double>::Zero();
  at.nu_ground = {0.5, 0.1, 0.0};
  CHECK(correction(1.5, 20.0) == Vec2<double>::Zero());
}
