#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "forces/force_modules.hpp"
#include "ship/ship.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

ForceModules<double> modules_of(const std::string& name) {
  const Ship ship = read_ship(name);
  return {*ship.modules, ship.particulars};
}

Vec3<double> rudder_force(const ForceModules<double>& modules, const Vec3<double>& nu, const Actuators<double>& a) {
  const auto flow = std::visit([&](const auto& m) { return m.flow(nu, a[Channel::n_p]); }, *modules.propeller);
  return std::visit([&](const auto& m) { return m.force(nu, flow, a); }, *modules.rudder);
}

Actuators<double> vectwin(double delta_p_deg, double delta_s_deg, double n_p) {
  Actuators<double> a;
  a[Channel::delta_p] = deg_to_rad(delta_p_deg);
  a[Channel::delta_s] = deg_to_rad(delta_s_deg);
  a[Channel::n_p] = n_p;
  return a;
}

Actuators<double> single(double delta_deg, double n_p) {
  Actuators<double> a;
  a[Channel::delta] = deg_to_rad(delta_deg);
  a[Channel::n_p] = n_p;
  return a;
}

}  // namespace

TEST_CASE("rudders: positive angles turn the bow to starboard and slow the ship", "[forces][rudder]") {
  const ForceModules<double> twin = modules_of("vectwin-3m"), one = modules_of("esso-osaka-3m");
  for (const double u : {0.0, 0.2, 0.5}) {
    const Vec3<double> a = rudder_force(twin, {u, 0.0, 0.0}, vectwin(20.0, 20.0, 10.0));
    const Vec3<double> b = rudder_force(one, {u, 0.0, 0.0}, single(20.0, 10.0));
    for (const Vec3<double>& force : {a, b}) {
      CHECK(force(0) < 0.0);
      CHECK(force(1) < 0.0);
      CHECK(force(2) > 0.0);
    }
  }
  CHECK(rudder_force(twin, {0.0, 0.0, 0.0}, vectwin(-105.0, 105.0, 10.0))(0) < 0.0);  // both out: astern
}

TEST_CASE("single rudder: mirrored motion and rudder give the mirrored force", "[forces][rudder]") {
  Ship ship = read_ship("esso-osaka-3m");
  auto& c = std::get<SingleRudderCoefficients<double>>(*ship.modules->rudder);
  c.gamma_R_positive = c.gamma_R_negative;  // the difference of the sides is in the ship, not in the model
  const ForceModules<double> modules(*ship.modules, ship.particulars);
  for (const double u : {-0.2, 0.0, 0.35})
    for (const double n : {-12.0, 0.0, 9.0})
      for (const double delta : {-35.0, 0.0, 17.0}) {
        CAPTURE(u, n, delta);
        const Vec3<double> a = rudder_force(modules, {u, 0.04, -0.05}, single(delta, n));
        const Vec3<double> b = rudder_force(modules, {u, -0.04, 0.05}, single(-delta, n));
        CHECK_THAT(b(0), WithinAbs(a(0), 1e-14));
        CHECK_THAT(b(1), WithinAbs(-a(1), 1e-14));
        CHECK_THAT(b(2), WithinAbs(-a(2), 1e-14));
      }
}

TEST_CASE("single rudder: behind a strongly reversed propeller the flow comes from astern", "[forces][rudder]") {
  const ForceModules<double> modules = modules_of("esso-osaka-3m");
  const Vec3<double> force = rudder_force(modules, {0.1, 0.0, 0.0}, single(20.0, -15.0));
  CHECK(force(2) < 0.0);
  CHECK(rudder_force(modules, {-0.2, 0.0, 0.0}, single(20.0, -15.0))(2) < 0.0);
}

TEST_CASE("rudders: every branch is finite, at rest, astern, stopped, and at extreme angles", "[forces][rudder]") {
  const ForceModules<double> twin = modules_of("vectwin-3m"), one = modules_of("esso-osaka-3m");
  for (const double u : {-0.4, -1e-9, 0.0, 1e-9, 0.4})
    for (const double v : {-0.2, -1e-9, 0.0, 1e-9, 0.2})
      for (const double r : {-0.1, 0.0, 0.1})
        for (const double n : {-10.0, 0.0, 1e-9, 10.0})
          for (const double delta : {-105.0, -37.5, 0.0, 35.0, 105.0}) {
            CAPTURE(u, v, r, n, delta);
            REQUIRE(rudder_force(twin, {u, v, r}, vectwin(delta, -delta, n)).allFinite());
            REQUIRE(rudder_force(one, {u, v, r}, single(delta, n)).allFinite());
          }
}

TEST_CASE("VecTwin rudders: the hull's share of the yaw moment is that of x_H, negative", "[forces][rudder]") {
  // At J = 0: a_H = 0.016 and x_H' = -0.159, so N / Y = (x_R + a_H x_H) / (1 + a_H).
  const ForceModules<double> twin = modules_of("vectwin-3m");
  const Vec3<double> force = rudder_force(twin, Vec3<double>::Zero(), vectwin(15.0, 25.0, 10.0));
  CHECK_THAT(force(2) / force(1), WithinRel((-1.5694 - 0.016 * 0.159 * 3.0) / 1.016, 1e-12));
}

TEST_CASE("VecTwin rudders: the normal force steps by less than 2 % at 37.5 deg", "[forces][rudder]") {
  const ForceModules<double> twin = modules_of("vectwin-3m");
  double largest = 0.0, force = 0.0;
  for (double delta = 30.0; delta < 50.0; delta += 0.01) {
    const double next = rudder_force(twin, {0.4, 0.0, 0.0}, vectwin(0.0, delta, 10.0))(1);
    if (force != 0.0) largest = std::max(largest, std::abs(next - force) / std::abs(force));
    force = next;
  }
  CHECK(largest > 0.001);
  CHECK(largest < 0.03);  // 1.8 % for C_N, and the change of the port rudder's share
}

TEST_CASE("rudders: what large angles give has two degrees of freedom, whichever way the flow comes",
          "[forces][rudder]") {
  const NormalForceShape<double> shape{.k_35 = 1.1, .k_90 = 0.8, .stall = std::nullopt};
  const auto factor = [&](double angle_deg) {
    const double a = deg_to_rad(angle_deg);
    return shape.factor(0.5 * std::cos(a), 0.5 * std::sin(a), 0.5);
  };
  CHECK(factor(0.0) == 1.0);
  CHECK_THAT(factor(35.0), WithinRel(1.1, 1e-12));
  CHECK_THAT(factor(90.0), WithinRel((1.0 + 0.1 / std::sin(deg_to_rad(35.0))) * 0.8, 1e-12));
  CHECK_THAT(factor(-60.0), WithinRel(factor(60.0), 1e-12));
  CHECK_THAT(factor(120.0), WithinRel(factor(60.0), 1e-12));
  CHECK_THAT(factor(35.001), WithinRel(factor(34.999), 1e-4));
}
