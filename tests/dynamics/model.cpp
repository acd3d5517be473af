#include "dynamics/model.hpp"

#include <fstream>

#include <catch2/catch.hpp>
#include <ceres/jet.h>

#include "core/units.hpp"
#include "dynamics/maneuvers.hpp"
#include "dynamics/model_parts.hpp"
#include "forces/registry.hpp"
#include "io/csv.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

using Jet = ceres::Jet<double, 8>;

struct Point {
  Vec3<double> nu;
  Actuators<double> actuators;
  Vec2<double> wind;
};

Point vectwin_point(double u, double v, double r, double p_deg, double s_deg, double n_p, double n_bt) {
  Point point{{u, v, r}, {}, {0.9, -0.6}};
  point.actuators[Channel::delta_p] = p_deg * kDegree;
  point.actuators[Channel::delta_s] = s_deg * kDegree;
  point.actuators[Channel::n_p] = n_p;
  point.actuators[Channel::n_bt] = n_bt;
  return point;
}

Point esso_point(double u, double v, double r, double delta_deg, double n_p) {
  Point point{{u, v, r}, {}, {-0.5, 1.3}};
  point.actuators[Channel::delta] = delta_deg * kDegree;
  point.actuators[Channel::n_p] = n_p;
  return point;
}

// d(acceleration)/d(u, v_m, r, wind x, wind y, first three actuators) by Jets against central differences. The step
// leaves an error of about 1e-8 of the larger entries where the model is smooth.
void check_derivatives(const Ship& ship, const Point& point) {
  const Model<double> model(ship);
  const Model<Jet> jet_model(ship);
  const std::vector<Channel> channels = ship.actuator_channels();
  const int n = 5 + static_cast<int>(std::min<std::size_t>(3, channels.size()));

  Vec3<Jet> nu;
  Vec2<Jet> wind;
  Actuators<Jet> actuators = point.actuators.cast<Jet>();
  for (int i = 0; i < 3; ++i) nu(i) = Jet(point.nu(i), i);
  for (int i = 0; i < 2; ++i) wind(i) = Jet(point.wind(i), 3 + i);
  for (int i = 5; i < n; ++i) actuators[channels[i - 5]] = Jet(point.actuators[channels[i - 5]], i);
  const Vec3<Jet> acceleration = jet_model.acceleration(nu, actuators, wind);

  for (int i = 0; i < n; ++i) {
    const double h = 1e-6;
    const auto at = [&](double shift) {
      Point p = point;
      if (i < 3)
        p.nu(i) += shift;
      else if (i < 5)
        p.wind(i - 3) += shift;
      else
        p.actuators[channels[i - 5]] += shift;
      return model.acceleration(p.nu, p.actuators, p.wind);
    };
    const Vec3<double> difference = (at(h) - at(-h)) / (2.0 * h);
    for (int k = 0; k < 3; ++k) {
      CAPTURE(i, k, point.nu.transpose());
      CHECK_THAT(acceleration(k).v(i), WithinAbs(difference(k), 1e-6 * (1.0 + std::abs(difference(k)))));
    }
  }
}

}  // namespace

TEST_CASE("model: autodiff derivatives agree with central differences on both sides of each branch", "[dynamics]") {
  const Ship twin = read_ship("vectwin-3m");
  for (const Point& point : {vectwin_point(0.4, 0.03, 0.02, -10.0, 12.0, 10.0, 8.0),
                             vectwin_point(0.4, -0.03, -0.02, 14.0, 12.0, 10.0, -8.0),
                             vectwin_point(0.2, 0.1, -0.05, -80.0, 70.0, 12.0, 20.0),
                             vectwin_point(-0.2, 0.06, 0.04, -105.0, 104.0, 10.0, -25.0),
                             vectwin_point(-0.1, -0.06, -0.03, -40.0, 50.0, 7.0, 25.0),
                             vectwin_point(0.7, -0.01, 0.03, 30.0, 33.0, 15.0, 10.0)})
    check_derivatives(twin, point);
  const Ship esso = read_ship("esso-osaka-3m");
  for (const Point& point : {esso_point(0.4, 0.03, 0.015, 12.0, 10.0), esso_point(0.3, -0.05, -0.03, -30.0, 2.0),
                             esso_point(0.2, 0.02, 0.03, 25.0, -3.0), esso_point(0.2, 0.02, 0.03, 25.0, -15.0),
                             esso_point(-0.1, 0.02, -0.03, 10.0, -15.0), esso_point(-0.15, -0.02, 0.03, -20.0, 10.0)})
    check_derivatives(esso, point);
  const Ship kvlcc2 = read_ship("kvlcc2-l7");
  for (const Point& point : {esso_point(1.1, 0.06, 0.03, 12.0, 11.0), esso_point(0.9, -0.2, 0.08, -30.0, 11.0),
                             esso_point(0.5, 0.1, 0.03, 25.0, -6.0), esso_point(-0.3, 0.04, -0.03, 100.0, -9.0),
                             esso_point(-0.5, -0.04, 0.03, -20.0, 9.0)})
    check_derivatives(kvlcc2, point);
}

TEST_CASE("model: derivatives at rest are finite", "[dynamics]") {
  for (const char* name : {"vectwin-3m", "esso-osaka-3m", "kvlcc2-l7"}) {
    const Model<Jet> model(read_ship(name));
    Vec3<Jet> nu;
    for (int i = 0; i < 3; ++i) nu(i) = Jet(0.0, i);
    Actuators<Jet> actuators;
    for (const double n : {0.0, 10.0}) {
      actuators[Channel::n_p] = Jet(n, 3);
      const Vec3<Jet> acceleration = model.acceleration(nu, actuators, Vec2<Jet>::Zero());
      for (int k = 0; k < 3; ++k) CHECK(acceleration(k).v.allFinite());
    }
  }
}

TEST_CASE("model: without forces, kinetic energy changes at the rate u v_m r (m_y - m_x)", "[dynamics]") {
  // With added mass the equations hold the Munk moment back for N_H; so d(energy)/dt is u v_m r (m_y - m_x), here zero
  // or not by choice of the added masses.
  const Ship ship = read_ship("vectwin-3m");
  for (const bool equal : {true, false}) {
    Inertia<double> inertia(ship.inertia, ship.particulars);
    if (equal) inertia.m_y = inertia.m_x;
    const Vec3<double> nu(0.41, -0.13, 0.07);
    const Vec3<double> rate = inertia.acceleration(nu, Vec3<double>::Zero());
    const double S = inertia.m * inertia.x_G, I = inertia.I_z + S * inertia.x_G;
    const double power = (inertia.m + inertia.m_x) * nu(0) * rate(0) + (inertia.m + inertia.m_y) * nu(1) * rate(1) +
                         I * nu(2) * rate(2) + S * (nu(1) * rate(2) + nu(2) * rate(1));
    CHECK_THAT(power, WithinAbs(nu(0) * nu(1) * nu(2) * (inertia.m_y - inertia.m_x), 1e-14));
  }
}

TEST_CASE("model: a ship without forces keeps its kinetic energy if m_x = m_y", "[dynamics]") {
  const Ship ship = read_ship("kvlcc2-l7");
  Inertia<double> inertia(ship.inertia, ship.particulars);
  inertia.m_y = inertia.m_x;
  const double S = inertia.m * inertia.x_G, I = inertia.I_z + S * inertia.x_G;
  const auto energy = [&](const Vec3<double>& nu) {
    return 0.5 * ((inertia.m + inertia.m_x) * nu.head<2>().squaredNorm() + I * nu(2) * nu(2)) + S * nu(1) * nu(2);
  };
  Vec3<double> nu(0.9, -0.4, 0.21);
  const double start = energy(nu), h = 0.01;
  const auto rate = [&](const Vec3<double>& x) { return inertia.acceleration(x, Vec3<double>::Zero()); };
  for (int i = 0; i < 5000; ++i) {
    const Vec3<double> k1 = rate(nu), k2 = rate(nu + 0.5 * h * k1), k3 = rate(nu + 0.5 * h * k2),
                       k4 = rate(nu + h * k3);
    nu += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  CHECK(std::abs(nu(1) + 0.4) > 0.1);               // it did move
  CHECK_THAT(energy(nu), WithinRel(start, 1e-11));  // of the method: (0.21 rad/s 0.01 s)^5 a step
}

TEST_CASE("model: the equations of motion hold for the accelerations that it returns", "[dynamics]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const Inertia<double> i(ship.inertia, ship.particulars);
  const Vec3<double> nu(0.3, -0.07, 0.05), force(0.4, -1.1, 0.6), a = i.acceleration(nu, force);
  const double u = nu(0), v = nu(1), r = nu(2);
  CHECK_THAT((i.m + i.m_x) * a(0) - (i.m + i.m_y) * v * r - i.x_G * i.m * r * r, WithinAbs(force(0), 1e-13));
  CHECK_THAT((i.m + i.m_y) * a(1) + (i.m + i.m_x) * u * r + i.x_G * i.m * a(2), WithinAbs(force(1), 1e-13));
  CHECK_THAT((i.I_z + i.x_G * i.x_G * i.m) * a(2) + i.x_G * i.m * (a(1) + u * r), WithinAbs(force(2), 1e-13));
}

TEST_CASE("model: mirrored states of the hull, the wind and the thruster mirror the accelerations", "[dynamics]") {
  Ship ship = read_ship("esso-osaka-3m");
  auto& rudder = std::get<SingleRudderCoefficients<double>>(*ship.modules->rudder);
  rudder.gamma_R_positive = rudder.gamma_R_negative;
  const Model<double> model(ship);
  Point point = esso_point(0.3, 0.05, -0.04, 17.0, 9.0);
  const Vec3<double> a = model.acceleration(point.nu, point.actuators, point.wind);
  point.nu.tail<2>() *= -1.0;
  point.wind(1) *= -1.0;
  point.actuators[Channel::delta] *= -1.0;
  const Vec3<double> b = model.acceleration(point.nu, point.actuators, point.wind);
  CHECK_THAT(b(0), WithinRel(a(0), 1e-12));
  CHECK_THAT(b(1), WithinRel(-a(1), 1e-12));
  CHECK_THAT(b(2), WithinRel(-a(2), 1e-12));
}
