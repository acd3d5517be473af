#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "dynamics/maneuvers.hpp"
#include "dynamics/model_parts.hpp"
#include "effects/effect_runs.hpp"
#include "forces/registry.hpp"

using namespace leeway;
using namespace leeway::test;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

// The rudders' force with a propeller that turns.
Vec3<double> rudder_force(const Model<double>& model, const Vec3<double>& nu, const Actuators<double>& actuators) {
  const Motion<double> motion(nu);
  const PropellerFlow<double> flow = std::visit([&](const auto& m) { return m.flow(motion, actuators[Channel::n_p]); },
                                                *model.parts().modules.propeller);
  return std::visit([&](const auto& m) { return m.force(motion, flow, actuators); }, *model.parts().modules.rudder);
}

Actuators<double> vectwin_actuators(double delta_p_deg, double delta_s_deg, double n_p) {
  Actuators<double> a;
  a[Channel::delta_p] = delta_p_deg * kDegree;
  a[Channel::delta_s] = delta_s_deg * kDegree;
  a[Channel::n_p] = n_p;
  return a;
}

}  // namespace

TEST_CASE("fouling: resistance ahead grows by its share", "[effects]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const Model<double> clean(ship), fouled(with(ship, "fouling", {{"resistance_increase", 0.25}}));
  const auto X = [](const Model<double>& model, double u) {
    return std::visit([&](const auto& hull) { return hull.force({u, 0.0, 0.0})(0); }, model.parts().modules.hull);
  };
  CHECK_THAT(X(fouled, 0.5), WithinRel(1.25 * X(clean, 0.5), 1e-12));
  CHECK_THAT(X(fouled, -0.3), WithinRel(1.25 * X(clean, -0.3), 1e-12));
  const auto wake = [](const Model<double>& model) {
    return std::visit(
        [](const auto& m) {
          return 1.0 - m.flow({0.5, 0.0, 0.0}, 10.0).one_minus_w_P;
        },
        *model.parts().modules.propeller);
  };
  CHECK_THAT(wake(fouled) - wake(clean), WithinAbs(0.03 * 0.25, 1e-12));
}

TEST_CASE("draft: a deeper ship is heavier, and less of it stands in the wind", "[effects]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const Model<double> light(ship), deep(with(ship, "draft", {{"draft_change", 0.1}}));
  CHECK_THAT(deep.parts().inertia.m, WithinRel(1.1 * light.parts().inertia.m, 1e-12));
  CHECK_THAT(deep.parts().inertia.I_z, WithinRel(1.1 * light.parts().inertia.I_z, 1e-12));
  const auto& hull = std::get<UnifiedHull<double>>(deep.parts().modules.hull).c;
  const auto& before = std::get<UnifiedHull<double>>(light.parts().modules.hull).c;
  CHECK_THAT(hull.X_0F, WithinRel(1.1 * before.X_0F, 1e-12));
  CHECK_THAT(hull.N_v, WithinRel(1.1 * 1.1 * before.N_v, 1e-12));  // -k, and the scale 0.5 rho L d
  const double k = 2.0 * 0.20114 / 3.0, C_b = 0.27078 * 3.0 / (2.0 * 0.48925), a = 1.4 * C_b * 0.48925 / 3.0;
  CHECK_THAT(hull.Y_v, WithinRel(1.1 * before.Y_v * (0.55 * kPi * k + a) / (0.5 * kPi * k + a), 1e-12));
  CHECK_THAT(hull.N_r, WithinRel(1.1 * before.N_r * (-0.54 * 1.1 + 1.21 * k) / (-0.54 + k), 1e-12));
  const auto wind = [](const Model<double>& model) {
    return std::visit([](const auto& m) { return m.force({0.3, 1.7}); }, *model.parts().modules.wind);
  };
  CHECK_THAT(wind(deep)(1) / wind(light)(1), WithinRel((0.52038 - 3.0 * 0.20114 * 0.1) / 0.52038, 1e-12));
  CHECK_THAT(wind(deep)(0) / wind(light)(0), WithinRel((0.13544 - 0.48925 * 0.20114 * 0.1) / 0.13544, 1e-12));
}

TEST_CASE("shallow water: check values at h/T = 1.5, and deep water as the limit", "[effects]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const auto factors = [&](double h_over_T) { return ShallowWater<double>({h_over_T}, ship).factors(ship); };
  const auto at = factors(1.5);
  CHECK_THAT(at.Y_v, WithinAbs(1.76, 0.005));
  CHECK_THAT(at.N_v, WithinAbs(1.93, 0.005));
  CHECK_THAT(at.N_r, WithinAbs(1.15, 0.005));
  CHECK_THAT(at.resistance, WithinRel(1.0 + 0.388 / 2.25, 1e-12));
  CHECK(at.m_y > 1.5);
  CHECK(at.J_z > 1.0);
  CHECK(at.w_P0 > 1.0);
  CHECK(at.gamma_R > 1.0);
  const auto deep = factors(1e7);
  for (const double k : {deep.m_y, deep.J_z, deep.Y_v, deep.N_v, deep.N_r, deep.resistance, deep.w_P0, deep.gamma_R})
    CHECK_THAT(k, WithinAbs(1.0, 1e-6));
  for (const double h : {1.25, 1.5, 2.0, 3.0}) CHECK(factors(h).Y_v > factors(h + 0.2).Y_v);

  const Model<double> shallow(with(ship, "shallow-water", {{"h_over_T", 1.5}})), open(ship);
  CHECK_THAT(shallow.parts().inertia.m_y, WithinRel(at.m_y * open.parts().inertia.m_y, 1e-12));
  CHECK_THAT(shallow.parts().inertia.m, WithinRel(open.parts().inertia.m, 1e-15));
  const double I_zG = open.parts().inertia.m * 0.0625 * 9.0;
  CHECK_THAT(shallow.parts().inertia.I_z - I_zG, WithinRel(at.J_z * (open.parts().inertia.I_z - I_zG), 1e-9));
}

TEST_CASE("shallow water: the ship turns wider, drifts less and keeps more speed", "[effects]") {
  Ship ship = read_ship("esso-osaka-3m");
  ship.modules->wind.reset();
  const auto steady = [](const Ship& s) {
    const auto maneuver = turning(s, 35.0 * kDegree);
    const Trajectory t = simulate(SimulatedShip(s), *maneuver, WindProcess(), {0.1, 1.0, 200.0});
    const double u = t[Channel::u].back(), v = t[Channel::vm].back(), r = t[Channel::r].back();
    return Vec3<double>(std::hypot(u, v) / r, std::atan2(-v, u), std::hypot(u, v));
  };
  const Vec3<double> deep = steady(ship), shallow = steady(with(ship, "shallow-water", {{"h_over_T", 1.5}}));
  CHECK(shallow(0) > 1.2 * deep(0));
  CHECK(shallow(1) < deep(1));
  CHECK(shallow(2) > deep(2));
}

TEST_CASE("gains: cross-flow drag, thrust, wake, rudders and thruster change what they name and nothing else",
          "[effects]") {
  const Ship ship = read_ship("vectwin-3m");
  const Model<double> plain(ship);
  const auto hull = [](const Model<double>& m, const Vec3<double>& nu) {
    return std::visit([&](const auto& h) { return h.force(nu); }, m.parts().modules.hull);
  };
  const Model<double> drag(with(ship, "cross-flow-drag", {{"C_D_gain", 1.4}}));
  const Vec3<double> crab(0.0, 0.2, 0.0), ahead(0.5, 0.0, 0.0);
  CHECK_THAT(hull(drag, crab)(1), WithinRel(1.4 * hull(plain, crab)(1), 1e-12));
  CHECK_THAT(hull(drag, ahead)(0), WithinRel(hull(plain, ahead)(0), 1e-15));

  const auto flow = [](const Model<double>& m, double u) {
    return std::visit([&](const auto& p) { return p.flow({u, 0.02, 0.01}, 9.0); }, *m.parts().modules.propeller);
  };
  const Model<double> loss(with(ship, "thrust-loss", {{"k_T", 0.8}}));
  for (const double u : {0.4, -0.2}) {
    CHECK_THAT(flow(loss, u).force(0), WithinRel(0.8 * flow(plain, u).force(0), 1e-12));
    CHECK_THAT(flow(loss, u).n2_K_T, WithinRel(0.8 * flow(plain, u).n2_K_T, 1e-12));  // what the rudders see
  }
  const Model<double> waked(with(ship, "wake", {{"wake_fraction_increase", 0.06}}));
  CHECK_THAT(flow(plain, 0.4).one_minus_w_P - flow(waked, 0.4).one_minus_w_P, WithinAbs(0.06, 1e-12));

  const Model<double> lost(with(ship, "rudder-effectiveness", {{"k_R", 0.9}, {"k_P", 0.5}}));
  const auto rudders = [&](const Model<double>& m) {
    return std::get<VectwinRudders<double>>(*m.parts().modules.rudder)
        .normal_forces({0.4, 0.02, 0.01}, flow(plain, 0.4), -0.5, 0.3);
  };
  CHECK_THAT(rudders(lost).port, WithinRel(0.45 * rudders(plain).port, 1e-12));
  CHECK_THAT(rudders(lost).starboard, WithinRel(0.9 * rudders(plain).starboard, 1e-12));

  Actuators<double> actuators;
  actuators[Channel::n_bt] = 20.0;
  const auto thruster = [&](const Model<double>& m, double u) {
    return std::visit([&](const auto& t) { return t.force({u, 0.0, 0.0}, actuators); }, m.parts().modules.thrusters[0]);
  };
  const Model<double> weak(with(ship, "thruster-gain", {{"k_BT", 0.7}}));
  CHECK_THAT(thruster(weak, 0.2)(1), WithinRel(0.7 * thruster(plain, 0.2)(1), 1e-12));
  const Model<double> slow(with(ship, "thruster-speed-loss", {{"u_c_mps", 0.4}}));
  CHECK_THAT(thruster(slow, 0.0)(2), WithinRel(thruster(plain, 0.0)(2), 1e-15));
  for (const double u : {0.4, -0.4})
    CHECK_THAT(thruster(slow, u)(2), WithinRel(std::exp(-1.0) * thruster(plain, u)(2), 1e-12));
}

TEST_CASE("rudder offset: the rudder acts as if it stood further to starboard", "[effects]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const Vec3<double> nu(0.5, 0.02, 0.01);
  const Vec3<double> a =
      acceleration(with(ship, "rudder-offset", {{"rudder_offset_deg", 3.0}}), nu, esso_actuators(4.0, 10.0));
  const Vec3<double> b = acceleration(ship, nu, esso_actuators(7.0, 10.0));
  for (int i = 0; i < 3; ++i) CHECK_THAT(a(i), WithinAbs(b(i), 1e-9));
  CHECK(a(2) > acceleration(ship, nu, esso_actuators(4.0, 10.0))(2));
  CHECK(a(1) < acceleration(ship, nu, esso_actuators(4.0, 10.0))(1));
}

TEST_CASE("center of gravity: it shifts x_G and nothing else, and a push at midship turns the bow back", "[effects]") {
  const Ship ship = read_ship("kvlcc2-l7");
  const Inertia<double> before = Model<double>(ship).parts().inertia;
  const Inertia<double> i = Model<double>(with(ship, "center-of-gravity", {{"x_g_change_m", 0.15}})).parts().inertia;
  CHECK_THAT(i.x_G, WithinRel(0.25 + 0.15, 1e-12));
  CHECK(i.m == before.m);
  CHECK(i.I_z == before.I_z);
  // (I_z + x_G^2 m) r' + x_G m v' = 0 under a side force at midship.
  const Vec3<double> rate = i.acceleration(Vec3<double>::Zero(), {0.0, 50.0, 0.0});
  CHECK_THAT((i.I_z + 0.16 * i.m) * rate(2), WithinRel(-0.4 * i.m * rate(1), 1e-12));
  CHECK(rate(2) < before.acceleration(Vec3<double>::Zero(), {0.0, 50.0, 0.0})(2));
}

TEST_CASE("trim: the derivatives by the cited factors, and course stability from trim by the stern", "[effects]") {
  const Ship ship = read_ship("kvlcc2-l7");
  const auto hull = [&](double tau) {
    return std::get<StandardHull<double>>(
               Model<double>(with(ship, "trim", {{"trim_over_draft", tau}})).parts().modules.hull)
        .c;
  };
  const auto stern = hull(0.15);
  CHECK_THAT(stern.Y_v, WithinRel(-0.315 * 1.1, 1e-12));
  CHECK_THAT(stern.Y_r, WithinRel(0.083 * 1.12, 1e-12));
  CHECK_THAT(stern.N_v, WithinRel(-0.137 * (1.0 - 0.27 * 0.15 / (0.137 / 0.315)), 1e-12));
  CHECK_THAT(stern.N_r, WithinRel(-0.049 * 1.045, 1e-12));
  CHECK(stern.Y_vvv == hull(0.0).Y_vvv);
  // Y_v (N_r - x_G m) - N_v (Y_r - m - m_x), positive where the ship keeps its course.
  const auto stability = [&](const StandardHullCoefficients<double>& c) {
    const auto& i = ship.inertia;
    return c.Y_v * (c.N_r - i.x_G * i.m) - c.N_v * (c.Y_r - i.m - i.m_x);
  };
  CHECK(stability(stern) > stability(hull(0.0)) + 1e-3);
  CHECK(stability(hull(-0.15)) < stability(hull(0.0)) - 1e-3);

  const Ship unified = read_ship("vectwin-3m");
  const Model<double> trimmed(with(unified, "trim", {{"trim_over_draft", -0.2}}));
  const auto& c = std::get<UnifiedHull<double>>(trimmed.parts().modules.hull).c;
  CHECK_THAT(c.N_v, WithinRel(-0.110037824 - 0.27 * 0.2 * 0.2089, 1e-12));
  CHECK_THAT(c.Y_r, WithinRel(-0.0786 * 0.84, 1e-12));
}

TEST_CASE("added mass: each factor multiplies its own", "[effects]") {
  const Ship ship = read_ship("kvlcc2-l7");
  const Inertia<double> a = Model<double>(ship).parts().inertia;
  const Inertia<double> b =
      Model<double>(with(ship, "added-mass", {{"k_mx", 1.4}, {"k_my", 0.7}, {"k_Jz", 1.3}})).parts().inertia;
  CHECK_THAT(b.m_x, WithinRel(1.4 * a.m_x, 1e-12));
  CHECK_THAT(b.m_y, WithinRel(0.7 * a.m_y, 1e-12));
  CHECK(b.m == a.m);
  const Particulars& p = ship.particulars;
  const double J_z = 0.011 * 0.5 * p.rho * std::pow(p.L_pp, 4.0) * p.d;  // published, with I_zG = m (0.25 L)^2
  CHECK_THAT(b.I_z - a.I_z, WithinRel(0.3 * J_z, 1e-9));
}

TEST_CASE("propeller walk: right-handed to starboard ahead, to port and stronger astern", "[effects]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const double D4 = std::pow(0.084, 4.0), rho = ship.particulars.rho;
  const auto force = [&](double n, const Parameters& more = {}) {
    Parameters parameters{{"c_Y", 0.02}, {"c_N", -0.009}};
    parameters.insert(parameters.end(), more.begin(), more.end());
    const Actuators<double> actuators = esso_actuators(0.0, n);
    Situation<double> at = at_heading(50.0);
    at.actuators = &actuators;
    return Effects<double>(with(ship, "propeller-walk", parameters)).force(at);
  };
  const Vec3<double> ahead = force(10.0), astern = force(-10.0);
  CHECK(ahead(0) == 0.0);
  CHECK_THAT(ahead(1), WithinRel(0.02 * rho * D4 * 100.0, 1e-12));
  CHECK_THAT(ahead(2), WithinRel(-0.009 * rho * D4 * 3.0 * 100.0, 1e-12));
  CHECK_THAT(astern(1), WithinRel(-3.0 * ahead(1), 1e-12));
  CHECK_THAT(astern(2), WithinRel(-3.0 * ahead(2), 1e-12));
  CHECK_THAT(force(-10.0, {{"astern_gain", 1.0}})(1), WithinRel(-ahead(1), 1e-12));
  CHECK_THAT(force(20.0)(1), WithinRel(4.0 * ahead(1), 1e-12));
  CHECK(force(0.0).isZero());
  // In a run it is there besides the modules, with the revolutions that act.
  const Vec3<double> nu(0.2, 0.0, 0.0);
  const Actuators<double> actuators = esso_actuators(0.0, -10.0);
  const Vec3<double> change =
      acceleration(with(ship, "propeller-walk", {{"c_Y", 0.02}, {"c_N", -0.009}}), nu, actuators) -
      acceleration(ship, nu, actuators);
  const Inertia<double> i = Model<double>(ship).parts().inertia;
  const Vec3<double> expected = i.acceleration(Vec3<double>::Zero(), astern);
  for (int k = 1; k < 3; ++k) CHECK_THAT(change(k), WithinRel(expected(k), 1e-3));

  // The size that its priors and its source claim: the reversed propeller of this model at rest.
  const Vec3<double> known = std::visit(
      [](const auto& m) {
        return m.flow({0.0, 0.0, 0.0}, -10.0).force;
      },
      *Model<double>(ship).parts().modules.propeller);
  const double c_Y = known(1) / (-rho * D4 * 100.0), c_N = known(2) / (-rho * D4 * 3.0 * 100.0);
  CHECK_THAT(c_Y, WithinAbs(0.024, 0.001));
  CHECK_THAT(c_N / c_Y, WithinAbs(-0.4, 0.01));
}

TEST_CASE("rudder stall: force is lost beyond the angle alone, alike on both sides and in flow from astern",
          "[effects]") {
  const Ship ship = read_ship("kvlcc2-l7");
  const Model<double> plain(ship), stalled(with(ship, "rudder-stall", {{"stall_angle_deg", 30.0}}));
  const auto ratio = [&](double u, double delta_deg, double n) {
    const Actuators<double> actuators = esso_actuators(delta_deg, n);
    return rudder_force(stalled, {u, 0.0, 0.0}, actuators)(1) / rudder_force(plain, {u, 0.0, 0.0}, actuators)(1);
  };
  // Straight ahead the angle of attack is the rudder angle.
  for (const double side : {1.0, -1.0}) {
    CHECK(ratio(1.0, side * 15.0, 10.0) == 1.0);
    CHECK(ratio(1.0, side * 29.9, 10.0) == 1.0);
    CHECK_THAT(ratio(1.0, side * 30.1, 10.0), WithinAbs(1.0 - 0.4 * 0.1 / 11.5, 1e-4));
    CHECK_THAT(ratio(1.0, side * 45.0, 10.0), WithinRel(1.0 - 0.4 * (1.0 - std::exp(-15.0 / 11.5)), 1e-12));
    CHECK(ratio(-1.0, side * 15.0, 0.0) == 1.0);
    CHECK_THAT(ratio(-1.0, side * 45.0, 0.0), WithinRel(1.0 - 0.4 * (1.0 - std::exp(-15.0 / 11.5)), 1e-12));
  }
  const Model<double> deep(
      with(ship, "rudder-stall", {{"stall_angle_deg", 20.0}, {"stall_depth", 0.55}, {"stall_width_deg", 2.0}}));
  const Actuators<double> hard = esso_actuators(70.0, 10.0);
  CHECK_THAT(rudder_force(deep, {1.0, 0.0, 0.0}, hard)(1) / rudder_force(plain, {1.0, 0.0, 0.0}, hard)(1),
             WithinAbs(0.45, 1e-9));
  CHECK_NOTHROW(Model<double>(with(ship, "rudder-stall", {{"stall_angle_deg", std::nullopt}})));
  CHECK_THROWS_WITH(
      Model<double>(with(ship, "rudder-stall", {{"stall_angle_deg", 30.0}, {"stall_depth", std::nullopt}})),
      Contains("/effects/0/stall_depth: expected a number from 0 to 1"));
}

TEST_CASE("rudder stall: each of two rudders stalls for itself, single rudders of both kinds stall", "[effects]") {
  const Ship ship = read_ship("vectwin-3m");
  const Model<double> plain(ship), stalled(with(ship, "rudder-stall", {{"stall_angle_deg", 30.0}}));
  const auto forces = [](const Model<double>& model) {
    const Motion<double> motion(0.4, 0.0, 0.0);
    return std::get<VectwinRudders<double>>(*model.parts().modules.rudder)
        .normal_forces(
            motion, std::visit([&](const auto& m) { return m.flow(motion, 10.0); }, *model.parts().modules.propeller),
            -60.0 * kDegree, 15.0 * kDegree);
  };
  CHECK(forces(stalled).starboard == forces(plain).starboard);
  const double lost = 1.0 - forces(stalled).port / forces(plain).port;
  CHECK(lost > 0.25);
  CHECK(lost < 0.4);
  const Ship esso = read_ship("esso-osaka-3m");
  const Actuators<double> hard = esso_actuators(-40.0, 10.0);
  CHECK(std::abs(rudder_force(Model<double>(with(esso, "rudder-stall", {{"stall_angle_deg", 25.0}})), {0.4, 0.0, 0.0},
                              hard)(1)) < 0.9 * std::abs(rudder_force(Model<double>(esso), {0.4, 0.0, 0.0}, hard)(1)));
}

TEST_CASE("VecTwin interaction: nothing for parallel rudders, its share and the race's drag for open ones",
          "[effects]") {
  const Ship ship = read_ship("vectwin-3m");
  const Model<double> plain(ship), disturbed(with(ship, "vectwin-interaction", {{"k_interaction", 0.2}}));
  const Vec3<double> nu(0.35, 0.04, 0.02);
  for (const double delta : {-20.0, 0.0, 33.0})
    CHECK((rudder_force(disturbed, nu, vectwin_actuators(delta, delta, 10.0)) -
           rudder_force(plain, nu, vectwin_actuators(delta, delta, 10.0)))
              .norm() < 1e-15);
  for (const auto& [port, starboard] : {std::pair(-75.0, 75.0), {-30.0, 0.0}, {-100.0, 20.0}}) {
    CAPTURE(port, starboard);
    const double lost = 0.2 * std::abs(std::sin((starboard - port) * kDegree));
    const double race = 0.7 * 10.0 * 0.1001 * 0.6835;  // 0.7 n P
    const Vec3<double> a = rudder_force(plain, nu, vectwin_actuators(port, starboard, 10.0));
    const Vec3<double> b = rudder_force(disturbed, nu, vectwin_actuators(port, starboard, 10.0));
    CHECK_THAT(b(0), WithinRel((1.0 - lost) * a(0) - lost * 0.5 * 998.0 * 0.0079662 * race * race, 1e-12));
    CHECK_THAT(b(1), WithinRel((1.0 - lost) * a(1), 1e-12));
    CHECK_THAT(b(2), WithinRel((1.0 - lost) * a(2), 1e-12));
  }
  // Without revolutions there is no race.
  const Vec3<double> still = rudder_force(plain, nu, vectwin_actuators(-75.0, 75.0, 0.0));
  CHECK_THAT(rudder_force(disturbed, nu, vectwin_actuators(-75.0, 75.0, 0.0))(0), WithinAbs(0.9 * still(0), 1e-12));
  CHECK_THROWS_WITH(Model<double>(with(read_ship("esso-osaka-3m"), "vectwin-interaction", {{"k_interaction", 0.1}})),
                    Contains("vectwin-interaction: the ship has a single rudder"));
  CHECK_THROWS_WITH(Model<double>(with(read_ship("ferry-40m"), "vectwin-interaction", {{"k_interaction", 0.1}})),
                    Contains("vectwin-interaction: the ship has no rudders"));
  CHECK_THROWS_WITH(Model<double>(with(read_ship("ferry-40m"), "thruster-speed-loss", {{"u_c_mps", 2.0}})),
                    Contains("thruster-speed-loss: the ship has no side thruster"));
}
