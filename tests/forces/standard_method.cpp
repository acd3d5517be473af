#include <cmath>

#include <catch2/catch.hpp>
#include <ceres/jet.h>

#include "core/units.hpp"
#include "forces/force_modules.hpp"
#include "ship/ship.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

const Ship& kvlcc2() {
  static const Ship ship = read_ship("kvlcc2-l7");
  return ship;
}

StandardHull<double> hull() {
  return {std::get<StandardHullCoefficients<double>>(kvlcc2().modules->hull), kvlcc2().particulars};
}

StandardPropeller<double> propeller() {
  return {std::get<StandardPropellerCoefficients<double>>(*kvlcc2().modules->propeller), kvlcc2().particulars};
}

StandardRudder<double> rudder(bool equal_sides = false) {
  auto c = std::get<StandardRudderCoefficients<double>>(*kvlcc2().modules->rudder);
  if (equal_sides) c.gamma_R_positive = c.gamma_R_negative;
  return {c, kvlcc2().particulars, {0.216, 0.0}};
}

Vec3<double> rudder_force(const StandardRudder<double>& module, const Vec3<double>& nu, double n, double delta) {
  Actuators<double> a;
  a[Channel::delta] = delta;
  return module.force(nu, propeller().flow(nu, n), a);
}

// Motions of 0.7 m/s at this drift angle [deg], with r'.
Vec3<double> motion(double beta_deg, double r, double U = 0.7) {
  return {U * std::cos(beta_deg * kDegree), -U * std::sin(beta_deg * kDegree), r * U / 7.0};
}

// Largest difference, as a share of the force scale 0.5 rho L d U^2 of 0.7 m/s; moments by L as well.
double share(const Vec3<double>& difference) {
  const double q = 0.5 * 1000.0 * 7.0 * 0.46 * 0.49;
  return std::max({std::abs(difference(0)), std::abs(difference(1)), std::abs(difference(2)) / 7.0}) / q;
}

}  // namespace

TEST_CASE("standard hull: within its range it is the printed polynomial", "[forces][hull]") {
  for (const double beta : {-29.0, -7.0, 0.0, 16.0, 29.9})
    for (const double yaw : {-0.95, -0.2, 0.0, 0.6, 0.99}) {
      const Vec3<double> nu = motion(beta, yaw, 1.1), force = hull().force(nu);
      const double v = -std::sin(beta * kDegree), r = yaw, q = 0.5 * 1000.0 * 7.0 * 0.46 * 1.1 * 1.1;
      const double X = -0.022 - 0.040 * v * v + 0.002 * v * r + 0.011 * r * r + 0.771 * std::pow(v, 4);
      const double Y =
          -0.315 * v + 0.083 * r - 1.607 * v * v * v + 0.379 * v * v * r - 0.391 * v * r * r + 0.008 * r * r * r;
      const double N =
          -0.137 * v - 0.049 * r - 0.030 * v * v * v - 0.294 * v * v * r + 0.055 * v * r * r - 0.013 * r * r * r;
      CAPTURE(beta, yaw);
      CHECK_THAT(force(0), WithinAbs(q * X, 1e-12 * q));
      CHECK_THAT(force(1), WithinAbs(q * Y, 1e-12 * q));
      CHECK_THAT(force(2), WithinAbs(q * 7.0 * N, 1e-11 * q));
    }
}

TEST_CASE("standard hull: mirrored to port and fore and aft it gives the mirrored force", "[forces][hull]") {
  for (const double u : {-0.6, -0.02, 0.0, 0.02, 0.9})
    for (const double v : {0.0, 0.05, 0.5})
      for (const double r : {-0.3, 0.0, 0.04}) {
        CAPTURE(u, v, r);
        const Vec3<double> force = hull().force({u, v, r});
        CHECK(hull().force({u, -v, -r}) == Vec3<double>(force(0), -force(1), -force(2)));
        CHECK(hull().force({-u, v, -r}) == Vec3<double>(-force(0), force(1), -force(2)));
      }
}

TEST_CASE("standard hull: it is continuous at every border of its ranges and at rest", "[forces][hull]") {
  const double tiny = 1e-9;  // deg or share; the slopes are of order 1
  for (const double yaw : {-1.4, -0.7, 0.0, 0.3, 1.2})
    for (const double beta : {-180.0, -150.0, -90.0, -30.0, 0.0, 30.0, 90.0, 150.0, 180.0}) {
      CAPTURE(beta, yaw);
      CHECK(share(hull().force(motion(beta + tiny, yaw)) - hull().force(motion(beta - tiny, yaw))) < 1e-8);
    }
  for (const double beta : {-160.0, -45.0, 0.0, 20.0, 90.0})
    for (const double yaw : {-1.0, 0.0, 1.0}) {
      CAPTURE(beta, yaw);
      CHECK(share(hull().force(motion(beta, yaw + tiny)) - hull().force(motion(beta, yaw - tiny))) < 1e-8);
    }
  CHECK(hull().force(Vec3<double>::Zero()).isZero(0.0));
  CHECK(share(hull().force({1e-7, -1e-7, 1e-8})) < 1e-12);
  CHECK(share(hull().force({1e-7, 1e-7, 0.05}) - hull().force({-1e-7, -1e-7, 0.05})) < 1e-6);
}

TEST_CASE("standard hull: everywhere it is finite and resists surge, sway and yaw", "[forces][hull]") {
  CHECK(hull().force({0.5, 0.0, 0.0})(0) < 0.0);
  CHECK(hull().force({-0.5, 0.0, 0.0})(0) > 0.0);
  for (const double r : {-0.2, 1e-6, 0.3}) {
    const Vec3<double> on_the_spot = hull().force({0.0, 0.0, r}), twice = hull().force({0.0, 0.0, 2.0 * r});
    CHECK(on_the_spot(2) * r < 0.0);
    CHECK_THAT(twice(2), WithinRel(4.0 * on_the_spot(2), 1e-12));  // r |r|
  }
  for (double beta = -180.0; beta <= 180.0; beta += 7.5) {
    const Vec3<double> drift = hull().force(motion(beta, 0.0));
    CHECK(drift.allFinite());
    CHECK(drift(1) * std::sin(beta * kDegree) > -1e-9);  // against the sway
    // Sideways it is not driven ahead by more than a few times its resistance.
    CHECK(share({drift(0), 0.0, 0.0}) < 0.025);
  }
}

TEST_CASE("standard propeller: the printed thrust, and a wake that has two sides", "[forces][propeller]") {
  const double D4 = std::pow(0.216, 4), n = 11.0, u = 0.9;
  for (const double v : {-0.3, -0.02, 0.0, 0.02, 0.3})
    for (const double r : {-0.08, 0.0, 0.05}) {
      const double U = std::hypot(u, v), beta_P = std::atan2(-v, u) + 0.48 * r * 7.0 / U;
      const double C_2 = beta_P > 0.0 ? 1.6 : 1.1;
      const double w = 0.6 * (1.0 + (1.0 - std::exp(-2.0 * std::abs(beta_P))) * (C_2 - 1.0));
      const double J = u * w / (n * 0.216);
      const PropellerFlow<double> flow = propeller().flow({u, v, r}, n);
      CAPTURE(v, r, beta_P);
      CHECK_THAT(flow.one_minus_w_P, WithinRel(w, 1e-13));
      CHECK_THAT(flow.J, WithinRel(J, 1e-13));
      CHECK_THAT(flow.force(0), WithinRel(0.78 * 1000.0 * n * n * D4 * (0.2931 - 0.2753 * J - 0.1385 * J * J), 1e-12));
      CHECK(flow.force(1) == 0.0);
      CHECK(flow.force(2) == 0.0);
    }
}

TEST_CASE("standard propeller: its force is continuous at n = 0, u = 0, beta_P = 0 and at rest",
          "[forces][propeller]") {
  const auto X = [](double u, double v, double r, double n) { return propeller().flow({u, v, r}, n).force(0); };
  for (const double u : {-0.8, 0.0, 1e-7, 0.9}) {
    CAPTURE(u);
    CHECK_THAT(X(u, 0.1, 0.02, 1e-9), WithinAbs(X(u, 0.1, 0.02, -1e-9), 1e-7));
    CHECK_THAT(X(u, 0.1, 0.02, 0.0), WithinAbs(X(u, 0.1, 0.02, -1e-9), 1e-7));
  }
  for (const double n : {-9.0, 0.0, 9.0}) {
    CAPTURE(n);
    CHECK_THAT(X(1e-9, 0.1, 0.02, n), WithinAbs(X(-1e-9, 0.1, 0.02, n), 1e-6));
    CHECK_THAT(X(1e-8, 0.0, 0.0, n), WithinAbs(X(0.0, 0.0, 0.0, n), 1e-6));
    const double beta = -0.11, r = 0.11 * 0.9 / std::cos(beta) / (0.48 * 7.0);  // beta_P = 0
    const auto side = [&](double e) { return X(0.9, -0.9 * std::tan(beta) + e, r, n); };
    CHECK(propeller().flow({0.9, -0.9 * std::tan(beta), r}, n).one_minus_w_P - 0.6 < 1e-12);
    CHECK_THAT(side(1e-9), WithinAbs(side(-1e-9), 1e-6));
  }
}

TEST_CASE("standard propeller: stopped it holds the ship back, reversed it follows the borrowed law",
          "[forces][propeller]") {
  CHECK(propeller().flow({0.8, 0.0, 0.0}, 0.0).force(0) < 0.0);
  CHECK(propeller().flow({-0.8, 0.0, 0.0}, 0.0).force(0) > 0.0);
  const double n = -8.0, D = 0.216, q = 1000.0 * n * n * std::pow(D, 4);
  CHECK_THAT(propeller().flow(Vec3<double>::Zero(), n).force(0), WithinRel(-0.175 * q, 1e-12));
  // At J_s = -0.233 the borrowed law steps by 0.4 %, the rounding of its numbers.
  const double u = 0.233 * -n * D;
  const double above = propeller().flow({u * 0.999999, 0.0, 0.0}, n).force(0) / q;
  const double below = propeller().flow({u * 1.000001, 0.0, 0.0}, n).force(0) / q;
  const double stopped = 0.78 * -0.1385 * std::pow(0.6 * 0.233, 2);
  CHECK_THAT(above, WithinAbs(-0.175 - 0.33 * 0.233 + stopped, 1e-6));
  CHECK_THAT(below, WithinAbs(-0.251 + stopped, 1e-6));
  CHECK_THAT(above / below, WithinAbs(1.0, 0.004));
  StandardPropeller<double> one_way = propeller();
  one_way.c.is_reversible = false;
  CHECK(one_way.flow({0.8, 0.1, 0.0}, -5.0).force == one_way.flow({0.8, 0.1, 0.0}, 0.0).force);
}

TEST_CASE("standard rudder: for a ship going ahead it is the printed equations, on both sides", "[forces][rudder]") {
  const double L = 7.0, n = 11.0, u = 0.9, eta = 0.216 / 0.345;
  for (const double v : {-0.3, 0.0, 0.3})
    for (const double r : {-0.08, 0.01, 0.08})
      for (const double delta : {-0.6, 0.3}) {
        const Vec3<double> nu(u, v, r);
        const PropellerFlow<double> flow = propeller().flow(nu, n);
        const double U = std::hypot(u, v), beta_R = std::atan2(-v, u) + 0.710 * r * L / U, J = flow.J;
        const double v_R = U * (beta_R > 0.0 ? 0.640 : 0.395) * beta_R;
        const double K_T = 0.2931 - 0.2753 * J - 0.1385 * J * J;
        const double jet = 1.0 + 0.50 * (std::sqrt(1.0 + 8.0 * K_T / (kPi * J * J)) - 1.0);
        const double u_R = 1.09 * u * flow.one_minus_w_P * std::sqrt(eta * jet * jet + 1.0 - eta);
        const double F_N =
            0.5 * 1000.0 * 0.0539 * (u_R * u_R + v_R * v_R) * 2.747 * std::sin(delta - std::atan2(v_R, u_R));
        const Vec3<double> force = rudder_force(rudder(), nu, n, delta);
        CAPTURE(v, r, delta, beta_R);
        CHECK_THAT(force(0), WithinRel(-(1.0 - 0.387) * F_N * std::sin(delta), 1e-11));
        CHECK_THAT(force(1), WithinRel(-(1.0 + 0.312) * F_N * std::cos(delta), 1e-11));
        CHECK_THAT(force(2), WithinRel(-(-0.5 - 0.312 * 0.464) * L * F_N * std::cos(delta), 1e-11));
      }
}

TEST_CASE("standard rudder: it is continuous where flow, drift or propeller change their side", "[forces][rudder]") {
  const double e = 1e-10;
  const auto jump = [](const Vec3<double>& a, double n_a, const Vec3<double>& b, double n_b) {
    return share(rudder_force(rudder(), a, n_a, 0.4) - rudder_force(rudder(), b, n_b, 0.4));
  };
  for (const double n : {-9.0, 0.0, 9.0}) {
    CAPTURE(n);
    CHECK(jump({e, 0.3, 0.05}, n, {-e, 0.3, 0.05}, n) < 1e-5);  // drift 90 deg; roots of small flows
    CHECK(jump({0.5, e, 0.0}, n, {0.5, -e, 0.0}, n) < 1e-8);    // beta_R = 0
    CHECK(jump({-0.5, e, 0.0}, n, {-0.5, -e, 0.0}, n) < 1e-8);  // drift 180 deg
    CHECK(jump({-0.5, e, 0.04}, n, {-0.5, -e, 0.04}, n) < 1e-8);
    CHECK(jump({1e-7, 0.0, 0.05}, n, {-1e-7, 0.0, 0.05}, n) < 1e-4);  // turning on the spot
    CHECK(jump({1e-8, 1e-8, 1e-8}, n, {0.0, 0.0, 0.0}, n) < 1e-5);    // rest
  }
  for (const double u : {-0.6, 0.0, 0.8}) {
    CAPTURE(u);
    CHECK(jump({u, 0.1, 0.02}, e, {u, 0.1, 0.02}, -e) < 1e-5);
    CHECK(jump({u, 0.1, 0.02}, 0.0, {u, 0.1, 0.02}, -e) < 1e-5);
  }
}

TEST_CASE("standard rudder: it turns the bow to starboard ahead, and to port in a flow from astern",
          "[forces][rudder]") {
  const auto N = [](double u, double n) { return rudder_force(rudder(), {u, 0.0, 0.0}, n, 0.3)(2); };
  CHECK(N(0.9, 11.0) > 0.0);
  CHECK(N(0.9, 0.0) > 0.0);
  CHECK(N(0.0, 11.0) > 0.0);
  CHECK(N(-0.9, 0.0) < 0.0);
  CHECK(N(-0.5, -9.0) < 0.0);
  CHECK(N(0.05, -9.0) < 0.0);
  CHECK(N(-0.1, 11.0) > 0.0);  // the race is stronger than the sternway
  // A stopped propeller in front leaves less of the flow; from astern the rudder meets it first.
  CHECK_THAT(rudder().eta, WithinRel(0.626, 1e-3));
}

TEST_CASE("standard rudder: mirrored motion and rudder give the mirrored force where the sides are equal",
          "[forces][rudder]") {
  for (const double u : {-0.6, 0.0, 0.8})
    for (const double delta : {-105.0, -35.0, 0.0, 20.0, 105.0}) {
      const StandardRudder<double> module = rudder(true);
      StandardPropeller<double> even = propeller();
      even.c.C_2_positive = even.c.C_2_negative;
      Actuators<double> a;
      a[Channel::delta] = delta * kDegree;
      const Vec3<double> nu(u, 0.2, -0.06), mirrored(u, -0.2, 0.06);
      const Vec3<double> starboard = module.force(nu, even.flow(nu, 8.0), a);
      a[Channel::delta] *= -1.0;
      const Vec3<double> port = module.force(mirrored, even.flow(mirrored, 8.0), a);
      CAPTURE(u, delta);
      CHECK(port == Vec3<double>(starboard(0), -starboard(1), -starboard(2)));
    }
}

TEST_CASE("standard method: derivatives of every module agree with central differences", "[forces]") {
  using Jet = ceres::Jet<double, 5>;  // by u, v_m, r, n, delta
  const Ship ship = kvlcc2();
  const ForceModules<double> modules(*ship.modules, ship.particulars);
  const ForceModules<Jet> jet_modules(*ship.modules, ship.particulars);
  const std::array<std::array<double, 5>, 10> points{{{1.1, 0.05, 0.02, 11.0, 0.2},    // ahead, beta_P < 0
                                                      {1.1, -0.15, 0.05, 11.0, -0.5},  // beta_P, beta_R > 0
                                                      {0.4, 0.5, 0.02, 11.0, 0.6},     // drift of more than 30 deg
                                                      {0.2, -0.1, 0.08, 4.0, 0.6},     // r' of more than 1
                                                      {0.9, 0.1, -0.02, 0.5, 0.3},     // K_T < 0
                                                      {0.9, 0.1, -0.02, -9.0, 0.3},
                                                      {0.3, 0.1, -0.02, -9.0, 0.3},  // J_s above its bound
                                                      {-0.4, 0.1, 0.03, 9.0, 1.8},
                                                      {-0.7, -0.1, 0.03, 1.5, -1.8},
                                                      {-0.4, -0.1, -0.03, -9.0, 0.3}}};
  for (const auto& point : points) {
    Vec3<Jet> nu;
    Actuators<Jet> actuators;
    for (int i = 0; i < 3; ++i) nu(i) = Jet(point[static_cast<std::size_t>(i)], i);
    actuators[Channel::n_p] = Jet(point[3], 3);
    actuators[Channel::delta] = Jet(point[4], 4);
    const auto parts = [](const auto& m, const auto& motion, const auto& inputs) {
      const auto flow = std::visit([&](const auto& k) { return k.flow(motion, inputs[Channel::n_p]); }, *m.propeller);
      return std::array{std::visit([&](const auto& k) { return k.force(motion); }, m.hull), flow.force,
                        std::visit([&](const auto& k) { return k.force(motion, flow, inputs); }, *m.rudder)};
    };
    const auto jets = parts(jet_modules, nu, actuators);
    for (int i = 0; i < 5; ++i) {
      const double h = 1e-6;
      const auto at = [&](double shift) {
        std::array<double, 5> p = point;
        p[static_cast<std::size_t>(i)] += shift;
        Actuators<double> a;
        a[Channel::n_p] = p[3];
        a[Channel::delta] = p[4];
        return parts(modules, Vec3<double>(p[0], p[1], p[2]), a);
      };
      const auto above = at(h), below = at(-h);
      for (std::size_t module = 0; module < 3; ++module)
        for (int k = 0; k < 3; ++k) {
          const double difference = (above[module](k) - below[module](k)) / (2.0 * h);
          CAPTURE(i, module, k, point[0], point[1], point[2], point[3]);
          // Forces are of order 1000 N, so rounding leaves 1e-7 N/1e-6 in the difference.
          CHECK_THAT(jets[module](k).v(i), WithinAbs(difference, 1e-5 * (1.0 + std::abs(difference))));
        }
    }
  }
}
