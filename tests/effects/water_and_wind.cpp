#include <catch2/catch.hpp>

#include "core/wind.hpp"
#include "dynamics/model_parts.hpp"
#include "effects/effect_runs.hpp"
#include "forces/registry.hpp"

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

TEST_CASE("steady current: the track is that in still water, carried along, to 1e-9 m", "[effects]") {
  // In calm air: wind would blow on a drifting ship.
  for (const char* name : {"esso-osaka-3m", "kvlcc2-l7"}) {
    Ship ship = read_ship(name);
    ship.modules->wind.reset();
    const double V = 0.11, set = 217.0 * kDegree;
    const Trajectory still = run(ship, 300.0);
    const Trajectory carried =
        run(with(ship, "steady-current", {{"current_speed_mps", V}, {"current_set_deg", 217.0}}), 300.0);
    for (std::size_t i = 0; i < still.size(); ++i) {
      const double t = still[Channel::t][i];
      CHECK_THAT(carried[Channel::x0][i], WithinAbs(still[Channel::x0][i] + V * std::cos(set) * t, 1e-9));
      CHECK_THAT(carried[Channel::y0][i], WithinAbs(still[Channel::y0][i] + V * std::sin(set) * t, 1e-9));
      CHECK_THAT(carried[Channel::psi][i], WithinAbs(still[Channel::psi][i], 1e-10));
    }
    // Velocities are over ground.
    CHECK_THAT(carried[Channel::u][0], WithinAbs(0.4 * ship.u0_mps + V * std::cos(set), 1e-12));
    CHECK_THAT(carried[Channel::vm][0], WithinAbs(V * std::sin(set), 1e-12));
  }
}

TEST_CASE("moving water: the equations over ground with added mass in u_c, v_c and dV/dt hold", "[effects]") {
  Ship ship = read_ship("esso-osaka-3m");
  ship.modules->wind.reset();
  const Model<double> model(with(ship, "varying-current", {{"current_sd_mps", 0.2}, {"tau_s", 8.0}, {"seed", 4.0}}));
  const double t = 31.0, h = 1e-4;
  const Vec3<double> eta(3.0, -5.0, 0.9), nu(0.45, -0.08, 0.05);
  const Inputs<double> now{esso_actuators(12.0, 11.0), Vec2<double>::Zero(), t};
  Inputs<double> middle = now, end = now, before = now, half_before = now;
  middle.t_s = t + h / 2.0;
  end.t_s = t + h;
  before.t_s = t - h;
  half_before.t_s = t - h / 2.0;
  // Over ground, centered: a step forward and, in reversed time, one back.
  const Vec3<double> ahead = integrate(model, {eta, nu}, {now, middle, end}, h).nu;
  const Vec3<double> back = integrate(model, {eta, nu}, {now, half_before, before}, -h).nu;
  const Vec3<double> rate = (ahead - back) / (2.0 * h);

  Situation<double> at = at_heading(eta(2) / kDegree);
  at.eta = eta;
  at.t_s = t;
  const WaterMotion<double> water = model.parts().effects.water(at);
  const Vec2<double> nu_c = at.to_ship(water.velocity), a = at.to_ship(water.rate);
  const Vec3<double> nu_r(nu(0) - nu_c(0), nu(1) - nu_c(1), nu(2));
  const Vec3<double> F = model.parts().modules.force(nu_r, now.actuators, Vec2<double>::Zero());
  CHECK(water.rate.norm() > 1e-3);
  check_moving_water(model.parts().inertia, nu, rate, nu_c, a, F);
}

TEST_CASE("varying current: a course that is known adds its cosines, and is held outside of them", "[effects]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const Effects<double> effects(with(ship, "varying-current",
                                     {{"current_sd_mps", 0.0},
                                      {"tau_s", 50.0},
                                      {"course_start_s", 100.0},
                                      {"course_s", 200.0},
                                      {"north_0_mps", 0.03},
                                      {"east_1_mps", -0.02},
                                      {"north_3_mps", 0.01}}));
  Situation<double> at = at_heading(0.0);
  const auto velocity = [&](double t) {
    at.t_s = t;
    return effects.water(at).velocity;
  };
  for (const double t : {100.0, 170.0, 300.0}) {
    CHECK_THAT(velocity(t)(0), WithinAbs(0.03 + 0.01 * std::cos(3.0 * kPi * (t - 100.0) / 200.0), 1e-15));
    CHECK_THAT(velocity(t)(1), WithinAbs(-0.02 * std::cos(kPi * (t - 100.0) / 200.0), 1e-15));
  }
  CHECK(velocity(20.0) == velocity(100.0));
  CHECK(velocity(900.0) == velocity(300.0));
  for (const double t : {20.0, 130.0, 250.0, 400.0}) {
    const Vec2<double> slope = (velocity(t + 1e-3) - velocity(t - 1e-3)) / 2e-3;
    at.t_s = t;
    CHECK((effects.water(at).rate - slope).norm() < 1e-9);
  }
}

TEST_CASE("varying current: its sd and its time constant are those asked for", "[effects]") {
  const Ship ship = read_ship("esso-osaka-3m");
  double variance = 0.0, lagged = 0.0;
  int n = 0;
  for (int seed = 1; seed <= 40; ++seed) {
    const Effects<double> effects(with(
        ship, "varying-current", {{"current_sd_mps", 0.05}, {"tau_s", 50.0}, {"seed", static_cast<double>(seed)}}));
    for (double t = 0.0; t < 2000.0; t += 25.0) {
      Situation<double> at = at_heading(0.0);
      at.t_s = t;
      const WaterMotion<double> now = effects.water(at);
      at.t_s = t + 50.0;
      const WaterMotion<double> later = effects.water(at);
      variance += now.velocity.squaredNorm();
      lagged += now.velocity.dot(later.velocity);
      n += 2;
      at.t_s = t + 0.01;
      const Vec2<double> ahead = effects.water(at).velocity;
      CHECK_THAT((ahead - now.velocity).norm() / 0.01, WithinAbs(now.rate.norm(), 2e-4));
    }
  }
  CHECK_THAT(std::sqrt(variance / n), WithinRel(0.05, 0.04));
  CHECK_THAT(lagged / variance, WithinAbs(std::exp(-1.0), 0.06));  // an Ornstein-Uhlenbeck process at lag tau
}

TEST_CASE("unmeasured wind: it adds to the recorded wind as a from-vector", "[effects]") {
  const Ship ship = read_ship("vectwin-3m");
  const Actuators<double> actuators = ship.initial_actuators();
  const Vec3<double> nu(0.3, 0.0, 0.0);
  const Ship windy = with(ship, "unmeasured-wind", {{"wind_speed_mps", 1.5}, {"wind_dir_deg", 75.0}});
  const Vec2<double> recorded = wind_from_vector(0.7, 3.0);
  const Vec3<double> a = acceleration(windy, nu, actuators, recorded);
  const Vec3<double> b = acceleration(ship, nu, actuators, recorded + wind_from_vector(1.5, 75.0 * kDegree));
  for (int i = 0; i < 3; ++i) CHECK_THAT(a(i), WithinAbs(b(i), 1e-9));
  // From starboard it pushes to port, from ahead it slows.
  const auto change = [&](double dir_deg) -> Vec3<double> {
    return acceleration(with(ship, "unmeasured-wind", {{"wind_speed_mps", 2.0}, {"wind_dir_deg", dir_deg}}), nu,
                        actuators) -
           acceleration(ship, nu, actuators);
  };
  CHECK(change(90.0)(1) < -1e-3);
  CHECK(change(0.0)(0) < -1e-4);
}

TEST_CASE("windage: each gain multiplies its own wind force", "[effects]") {
  const Ship ship = read_ship("vectwin-3m");
  const Model<double> plain(ship), gained(with(ship, "windage", {{"kX", 1.3}, {"kY", 0.6}, {"kN", 2.0}}));
  const Vec2<double> wind(1.1, -0.8);
  const auto force = [&](const Model<double>& model) {
    return std::visit([&](const auto& m) { return m.force(wind); }, *model.parts().modules.wind);
  };
  const Vec3<double> a = force(plain), b = force(gained);
  CHECK_THAT(b(0), WithinRel(1.3 * a(0), 1e-12));
  CHECK_THAT(b(1), WithinRel(0.6 * a(1), 1e-12));
  CHECK_THAT(b(2), WithinRel(2.0 * a(2), 1e-12));
}

TEST_CASE("wave drift: it pushes to leeward, turns with the sea and grows with the square of the height", "[effects]") {
  const auto force = [](double hs, double from_deg, double psi_deg) {
    return force_of("wave-drift",
                    {{"hs_m", hs}, {"wave_from_deg", from_deg}, {"C_X", 1.0}, {"C_Y", 0.8}, {"C_N", 0.03}}, psi_deg);
  };
  const Ship ship = read_ship("vectwin-3m");
  const Particulars& p = ship.particulars;
  const double rho_g = p.rho * kGravity_mps2;
  // Beam sea from starboard: Y = -rho g L hs^2/16 C_Y, no X, no N.
  const Vec3<double> beam = force(0.02, 130.0, 40.0);
  CHECK_THAT(beam(1), WithinRel(-rho_g * p.L_pp * 0.02 * 0.02 / 16.0 * 0.8, 1e-12));
  CHECK_THAT(beam(0), WithinAbs(0.0, 1e-12));
  CHECK_THAT(beam(2), WithinAbs(0.0, 1e-12));
  // Head sea: X = -rho g B^2/L hs^2/8 C_X.
  CHECK_THAT(force(0.02, 40.0, 40.0)(0), WithinRel(-rho_g * p.B * p.B / p.L_pp * 0.02 * 0.02 / 8.0, 1e-12));
  // Bow quarter from starboard: N = -rho g L^2 hs^2/16 C_N; sin mu |sin mu| is 1/2.
  const Vec3<double> quarter = force(0.02, 85.0, 40.0);
  CHECK_THAT(quarter(2), WithinRel(-rho_g * p.L_pp * p.L_pp * 0.02 * 0.02 / 16.0 * 0.03, 1e-12));
  CHECK_THAT(quarter(1), WithinRel(0.5 * beam(1), 1e-12));
  CHECK_THAT(force(0.04, 85.0, 40.0)(1), WithinRel(4.0 * quarter(1), 1e-12));
  CHECK_THAT(force(0.02, -5.0, 40.0)(1), WithinRel(-quarter(1), 1e-12));  // mirrored
}

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
      CHECK_THAT(model.parts().effects.water(at_pose(2.0, 1.0, psi)).turn(at_pose(2.0, 1.0, psi)),
                 WithinRel(Omega, 1e-12));
      // At the center, where the water does not move: what is left is the centrifugal force on the center of gravity.
      const Inputs<double> idle{Actuators<double>(), Vec2<double>::Zero(), 0.0};
      const Vec3<double> rate = rate_of_change(model, {{0.0, 0.0, psi}, {0.0, 0.0, Omega}}, idle).nu;
      const Inertia<double>& i = model.parts().inertia;
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
  ship.modules->wind.reset();
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
  const Vec3<double> F =
      model.parts().modules.force({nu_r(0), nu_r(1), nu(2) - g}, inputs.actuators, Vec2<double>::Zero());
  CHECK(std::abs(g) > 5e-3);
  CHECK(a.norm() > 5e-3);
  check_moving_water(model.parts().inertia, nu, rate, nu_c, a, F);
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
