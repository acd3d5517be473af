#include "forces/azimuth_thruster.hpp"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>
#include <ceres/jet.h>
#include <nlohmann/json.hpp>

#include "dynamics/maneuvers.hpp"
#include "dynamics/model.hpp"
#include "dynamics/straight_run.hpp"
#include "forces/registry.hpp"
#include "io/files.hpp"
#include "io/json.hpp"
#include "io/trajectory_csv.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

Ship ferry() { return read_ship("ferry-40m"); }

// Fore and aft thruster: revolutions [1/s] and angles [deg].
Actuators<double> thrusters(double n_1, double az_1_deg, double n_2, double az_2_deg) {
  Actuators<double> a;
  a[Channel::n_az1] = n_1;
  a[Channel::az1] = az_1_deg * kDegree;
  a[Channel::n_az2] = n_2;
  a[Channel::az2] = az_2_deg * kDegree;
  return a;
}

Vec3<double> sum_of(const ModuleForces<double>& f) {
  return f.propeller.force + f.hull + f.rudder + f.thrusters + f.wind;
}

// Without air, which tells bow from stern.
Vec3<double> thrust(const Vec3<double>& nu, const Actuators<double>& a) {
  return Model<double>(ferry()).forces(nu, a, Vec2<double>::Zero()).thrusters;
}
Vec3<double> acceleration(const Vec3<double>& nu, const Actuators<double>& a) {
  return Model<double>(ferry()).acceleration(nu, a, Vec2<double>::Zero());
}

// The ship after orders that stand, without air.
ShipState<double> after(double duration_s, const Vec3<double>& nu, const Actuators<double>& a) {
  Ship ship = ferry();
  ship.modules->wind.reset();
  SimulatedShip run(ship, 0.0);
  run.state.nu = nu;
  run.actuators = a;
  for (double t = 0.0; t < duration_s; t += 0.1) run.step(a, Vec2<double>::Zero(), 0.1);
  return run.state;
}

template <typename Change>
void read_changed(const Change& change) {
  io::Json json = io::read_json(io::find_config("ships", "ferry-40m"));
  change(json);
  const test::TemporaryFolder folder;
  read_ship(folder.write("ship.json", io::to_text(json)));
}

const Vec3<double> kMotions[] = {{4.0, 0.3, 0.02}, {-2.0, 0.7, 0.04}, {0.2, -1.1, -0.03}, {0.0, 0.0, 0.05}};
const double kAngles[][2] = {{0.0, 0.0}, {35.0, -20.0}, {120.0, 70.0}, {-95.0, 185.0}};

}  // namespace

TEST_CASE("azimuth thrusters: bollard pull by hand, in the direction of the thrust", "[forces][azimuth]") {
  const double T = 1025.0 * std::pow(1.3, 4) * 16.0 * 0.4266;  // n = 4 1/s
  const Vec3<double> ahead = thrust(Vec3<double>::Zero(), thrusters(4.0, 0.0, 4.0, 0.0));
  CHECK_THAT(ahead(0), WithinRel(2.0 * 0.88 * T, 1e-12));
  CHECK_THAT(ahead(1), WithinAbs(0.0, 1e-9));
  const Vec3<double> one = thrust(Vec3<double>::Zero(), thrusters(0.0, 0.0, 4.0, 30.0));
  CHECK_THAT(one(0), WithinRel(0.88 * T * std::cos(30.0 * kDegree), 1e-12));
  CHECK_THAT(one(1), WithinRel(0.5 * T, 1e-12));
  CHECK_THAT(one(2), WithinRel(-17.0 * 0.5 * T, 1e-12));
  CHECK(thrust(Vec3<double>::Zero(), thrusters(-4.0, 20.0, 0.0, 0.0)).isZero(0.0));  // they turn, they do not reverse
}

TEST_CASE("azimuth thrusters: on a straight run their thrust less its deduction is the resistance",
          "[forces][azimuth]") {
  Ship ship = ferry();
  ship.modules->wind.reset();
  const double u = 5.0, n = self_propulsion_n(ship, u), J = 0.92 * u / (n * 1.3);
  const double K_T = 0.4266 - 0.2548 * J - 0.1348 * J * J;
  CHECK_THAT(2.0 * 0.88 * 1025.0 * std::pow(1.3, 4) * n * n * K_T,
             WithinRel(0.5 * 1025.0 * 40.0 * 2.0 * 0.0231 * u * u, 1e-12));
  CHECK_THAT(steady_speed(ship, n), WithinRel(u, 1e-12));
}

TEST_CASE("azimuth thrusters: the force across is the momentum that the race takes off the cross flow",
          "[forces][azimuth]") {
  // At 90 deg and n > 0 a ship that goes ahead flows across; the mass flow is that of the disk at rest.
  const double u = 0.8, T = 1025.0 * std::pow(1.3, 4) * 16.0 * 0.4266, A = 0.25 * kPi * 1.3 * 1.3;
  const double mass_flow = 1025.0 * A * std::sqrt(T / (2.0 * 1025.0 * A));
  const Vec3<double> f = thrust({u, 0.0, 0.0}, thrusters(4.0, 90.0, 0.0, 90.0));
  CHECK_THAT(f(0), WithinRel(-0.6 * mass_flow * 0.92 * u, 1e-10));
  CHECK_THAT(f(1), WithinRel(T, 1e-10));
}

TEST_CASE("azimuth thrusters: port and starboard mirror each other", "[forces][azimuth]") {
  for (const Vec3<double>& nu : kMotions)
    for (const auto& [first, second] : kAngles) {
      const Vec3<double> f = acceleration(nu, thrusters(4.0, first, 3.0, second));
      const Vec3<double> mirrored = acceleration({nu(0), -nu(1), -nu(2)}, thrusters(4.0, -first, 3.0, -second));
      CHECK((mirrored - Vec3<double>(f(0), -f(1), -f(2))).norm() < 1e-13);
    }
}

TEST_CASE("azimuth thrusters: a double-ended ferry runs astern as it runs ahead", "[forces][azimuth]") {
  for (const Vec3<double>& nu : kMotions)
    for (const auto& [first, second] : kAngles) {
      const Vec3<double> f = acceleration(nu, thrusters(4.0, first, 3.0, second));
      const Vec3<double> other_end =
          acceleration({-nu(0), nu(1), -nu(2)}, thrusters(3.0, 180.0 - second, 4.0, 180.0 - first));
      CHECK((other_end - Vec3<double>(-f(0), f(1), -f(2))).norm() < 1e-13);
    }
  const ShipState<double> ahead = after(60.0, {3.0, 0.0, 0.0}, thrusters(4.0, 0.0, 5.0, 25.0));
  const ShipState<double> astern = after(60.0, {-3.0, 0.0, 0.0}, thrusters(5.0, 155.0, 4.0, 180.0));
  CHECK(std::abs(ahead.eta(2)) > 0.3);
  CHECK_THAT(astern.eta(0), WithinAbs(-ahead.eta(0), 1e-8));
  CHECK_THAT(astern.eta(1), WithinAbs(ahead.eta(1), 1e-8));
  CHECK_THAT(astern.eta(2), WithinAbs(-ahead.eta(2), 1e-10));
}

TEST_CASE("azimuth thrusters: both at 90 deg crab the ferry, without surge and yaw", "[forces][azimuth]") {
  for (const double side : {1.0, -1.0}) {
    const Actuators<double> a = thrusters(5.0, 90.0 * side, 5.0, 90.0 * side);
    const ShipState<double> state = after(400.0, Vec3<double>::Zero(), a);
    CHECK_THAT(state.nu(0), WithinAbs(0.0, 1e-9));
    CHECK_THAT(state.nu(2), WithinAbs(0.0, 1e-12));
    CHECK(side * state.nu(1) > 0.5);
    // Thrust at the advance ratio of the sway balances the drag of the cross flow: no sway is left to gain.
    const Vec3<double> f = Model<double>(ferry()).forces(state.nu, a, Vec2<double>::Zero()).hull;
    CHECK_THAT(thrust(state.nu, a)(1), WithinRel(-f(1), 1e-6));
  }
}

TEST_CASE("azimuth thrusters: in a steady turn forces are the momentum's change", "[forces][azimuth]") {
  const Actuators<double> a = thrusters(4.5, 0.0, 4.5, -30.0);
  const ShipState<double> state = after(1500.0, {4.0, 0.0, 0.0}, a);
  const double u = state.nu(0), v = state.nu(1), r = state.nu(2);
  CHECK(r > 0.01);  // thrust of the stern to port turns the bow to starboard
  CHECK(v < 0.0);
  const Ship ship = ferry();
  const Inertia<double> inertia(ship.inertia, ship.particulars);
  const Vec3<double> f = sum_of(Model<double>(ship).forces(state.nu, a, Vec2<double>::Zero()));
  CHECK_THAT(f(0), WithinRel(-(inertia.m + inertia.m_y) * v * r, 1e-6));
  CHECK_THAT(f(1), WithinRel((inertia.m + inertia.m_x) * u * r, 1e-6));
  CHECK_THAT(f(2), WithinAbs(0.0, 1e-6 * 17.0 * f(1)));
}

TEST_CASE("azimuth thrusters: 360 deg are 0 deg, and a thruster turns the short way", "[forces][azimuth]") {
  for (const Vec3<double>& nu : kMotions) {
    const Vec3<double> once = thrust(nu, thrusters(4.0, 350.0, 3.0, -170.0));
    const Vec3<double> again = thrust(nu, thrusters(4.0, -10.0, 3.0, 910.0));
    CHECK((once - again).norm() < 1e-10 * once.norm());
  }
  const Ship ship = ferry();
  const Actuator& az = *ship.find_actuator(Channel::az1);
  CHECK_THAT(respond(az, 350.0 * kDegree, 10.0 * kDegree, 100.0), WithinAbs(370.0 * kDegree, 1e-9));
  CHECK_THAT(respond(az, -170.0 * kDegree, 170.0 * kDegree, 100.0), WithinAbs(-190.0 * kDegree, 1e-9));
  CHECK_THAT(respond(az, 0.0, 170.0 * kDegree, 2.0), WithinAbs(30.0 * kDegree, 1e-9));  // 15 deg/s
}

TEST_CASE("azimuth thrusters: recorded angles are read wrapped or not", "[io][azimuth]") {
  const test::TemporaryFolder folder;
  const Trajectory t = io::read_trajectory(folder.write(
      "a.csv",
      "t_s,u_mps,vm_mps,r_degps,n_az1_rps,az1_deg\n0,1,0,0,3,340\n1,1,0,0,3,350\n2,1,0,0,3,5\n3,1,0,0,3,20\n"));
  REQUIRE(t.has(Channel::az1));
  CHECK_THAT(t[Channel::az1][2], WithinAbs(365.0 * kDegree, 1e-12));
  CHECK_THAT(t[Channel::az1][3], WithinAbs(380.0 * kDegree, 1e-12));
  CHECK(io::trajectory_text(t).starts_with("t_s,u_mps,vm_mps,r_degps,n_az1_rps,az1_deg\n"));
}

TEST_CASE("azimuth thrusters: a turning order steers each end to its side", "[dynamics][azimuth]") {
  const Ship ship = ferry();
  Actuators<double> command;
  order_rudders(ship, 0.3, command);
  CHECK(command[Channel::az1] == 0.3);
  CHECK(command[Channel::az2] == -0.3);
  const auto maneuver = turning(ship, 0.3);
  const Trajectory t = simulate(steady_ahead(ship, 4.0), *maneuver, WindProcess::steady(0.0, 0.0), {0.1, 1.0, 60.0});
  CHECK(t[Channel::r].back() > 0.02);
  CHECK_THAT(t[Channel::az2].back(), WithinAbs(-0.3, 1e-9));
}

TEST_CASE("azimuth thrusters: derivatives are those of differences", "[forces][azimuth]") {
  using Jet = ceres::Jet<double, 5>;
  const Ship ship = ferry();
  const auto& c = std::get<AzimuthThrusterCoefficients<double>>(ship.modules->thrusters[0]);
  const AzimuthThruster<double> module(c, ship.particulars);
  const AzimuthThruster<Jet> jets(c, ship.particulars);
  const auto at = [&](const std::array<double, 5>& p) {
    Actuators<double> a;
    a[Channel::n_az1] = p[3];
    a[Channel::az1] = p[4];
    return module.force({p[0], p[1], p[2]}, a);
  };
  for (const std::array<double, 5>& point :
       {std::array{4.0, 0.3, 0.02, 4.0, 0.4}, std::array{-3.0, 0.5, -0.03, 2.0, 0.2},
        std::array{5.0, 0.1, 0.01, 0.5, 0.1}, std::array{1.0, -0.8, 0.02, 3.0, 4.0}}) {
    Actuators<Jet> a;
    a[Channel::n_az1] = Jet(point[3], 3);
    a[Channel::az1] = Jet(point[4], 4);
    const Vec3<Jet> f = jets.force({Jet(point[0], 0), Jet(point[1], 1), Jet(point[2], 2)}, a);
    for (std::size_t i = 0; i < 5; ++i) {
      std::array<double, 5> up = point, down = point;
      up[i] += 1e-5;
      down[i] -= 1e-5;
      const Vec3<double> slope = (at(up) - at(down)) / 2e-5;
      CAPTURE(point, i);
      for (int k = 0; k < 3; ++k)
        CHECK_THAT(f(k).v[static_cast<long>(i)], WithinAbs(slope(k), 1e-6 * slope.norm() + 1e-2));
    }
  }
}

TEST_CASE("azimuth thrusters: their coefficients have names, and thrust-loss takes their thrust",
          "[dynamics][azimuth]") {
  Ship ship = ferry();
  const Model<double> model(ship);
  CHECK(model.modules() == std::vector<std::string>{"hull", "azimuth", "wind"});
  std::vector<std::string> names;
  for (const Coefficient& c : model.coefficients()) names.push_back(c.name);
  for (const char* name : {"azimuth.K_T_1", "azimuth.1-w_2", "azimuth.k_turned_1"})
    CHECK(std::count(names.begin(), names.end(), name) == 1);
  Ship loses = ship;
  loses.effects.push_back({"thrust-loss", {{"k_T", 0.8}}, "ship.json", "/effects/0"});
  ship.multiply({{"azimuth.K_T_1", 0.8}, {"azimuth.K_T_2", 0.8}});
  const Vec3<double> nu(3.0, 0.2, 0.01);
  const auto of = [&](const Ship& s) {
    return Model<double>(s).acceleration(nu, thrusters(4.0, 10.0, 3.0, -20.0), Vec2<double>::Zero());
  };
  CHECK((of(loses) - of(ship)).norm() < 1e-14);
  CHECK((of(loses) - of(ferry())).norm() > 1e-3);
  for (const char* effect : {"rudder-offset", "rudder-stall", "propeller-walk", "thruster-gain"}) {
    Ship without = ferry();
    without.effects.push_back({effect, {}, "ship.json", "/effects/0"});
    CHECK_THROWS_WITH(Model<double>(without), Contains("/effects/0"));
  }
}

TEST_CASE("azimuth thrusters: wrong keys and actuators are refused with their place", "[ship][azimuth]") {
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["thrusters"][0]["channel"] = "n_bt"; }),
                    Contains("/thrusters/0/channel: unknown 'n_bt'; known: n_az1, n_az2"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["thrusters"][1].erase("k_turned"); }),
                    Contains("/thrusters/1/k_turned: missing"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["actuators"].erase(1); }), Contains("no actuator 'az1'"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["actuators"][1]["max_deg"] = 90; }),
                    Contains("/actuators/1/max_deg: unknown key"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["thrusters"].clear(); }), Contains("/propeller: missing"));
  CHECK_THROWS_WITH(read_changed([](io::Json& j) { j["rudder"] = io::Json::object(); }),
                    Contains("/propeller: missing"));
}
