#include <fstream>
#include <sstream>

#include <catch2/catch.hpp>
#include <ceres/jet.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/maneuvers.hpp"
#include "dynamics/replay.hpp"
#include "effects/catalogue.hpp"
#include "effects/effect_runs.hpp"
#include "temporary_folder.hpp"

using namespace leeway;
using namespace leeway::test;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

// Values of strength: each parameter at its prior's median or, where that is neutral, one sd away.
double plausible(const EffectParameter& p) {
  if (p.name == "t_start_s") return 10.0;
  if (p.name == "t_end_s") return 40.0;
  if (p.name == "rate_degps") return 2.0;
  if (p.name == "stall_angle_deg") return 15.0;
  if (p.name == "wall_distance_m") return 2.0;
  if (p.name == "wall_direction_deg") return 30.0;
  const double value = p.at_3m.median;
  if (value != p.off) return value;
  return p.at_3m.kind == Prior::Kind::log_normal ? value * std::exp(p.at_3m.sd) : value + p.at_3m.sd;
}

bool is_applicable(const Ship& ship, const EffectDescription& effect) {
  try {
    std::vector<double> values;
    for (const EffectParameter& p : effect.parameters) values.push_back(plausible(p));
    for (std::size_t i = 0; i < effect_catalogue().size(); ++i)
      if (effect_catalogue()[i].info.name == effect.info.name)
        make_effect<double>(i, std::span<const double>(values), ship);
    return true;
  } catch (const EffectNotApplicable&) {
    return false;
  }
}

}  // namespace

TEST_CASE("effects: at zero strength every effect changes nothing, to the last bit", "[effects]") {
  for (const char* name : {"vectwin-3m", "esso-osaka-3m", "kvlcc2-l7"}) {
    const Ship ship = read_ship(name);
    const Trajectory without = run(ship);
    for (const EffectDescription& effect : effect_catalogue()) {
      if (!is_applicable(ship, effect)) continue;
      Parameters off;
      for (const EffectParameter& p : effect.parameters) {
        if (!std::isnan(p.off))
          off.emplace_back(p.name, p.off);
        else if (is_switch(effect, p))
          off.emplace_back(p.name, std::nullopt);
        else
          off.emplace_back(p.name, plausible(p));
      }
      CAPTURE(name, effect.info.name);
      check_same_bits(run(with(ship, std::string(effect.info.name), off)), without);
    }
  }
}

TEST_CASE("effects: at a plausible strength every effect changes the motion, and it stays finite", "[effects]") {
  for (const char* name : {"vectwin-3m", "esso-osaka-3m", "kvlcc2-l7"}) {
    const Ship ship = read_ship(name);
    const Trajectory without = run(ship);
    for (const EffectDescription& effect : effect_catalogue()) {
      if (!is_applicable(ship, effect)) continue;
      Parameters some;
      for (const EffectParameter& p : effect.parameters)
        if (ship.has_twin_rudders() || (p.name != "k_P" && p.name != "k_S")) some.emplace_back(p.name, plausible(p));
      CAPTURE(name, effect.info.name);
      const Trajectory changed = run(with(ship, std::string(effect.info.name), some));
      CHECK(largest_difference(changed, without, Channel::u) + largest_difference(changed, without, Channel::vm) >
            1e-5);
      for (const double x : changed[Channel::x0]) CHECK(std::isfinite(x));
    }
  }
}

TEST_CASE("effects: derivatives by the parameters agree with central differences", "[effects]") {
  using Jet = ceres::Jet<double, 1>;
  const Ship ship = read_ship("vectwin-3m");
  Actuators<double> actuators;
  actuators[Channel::delta_p] = -0.3;
  actuators[Channel::delta_s] = 0.7;
  actuators[Channel::n_p] = 10.0;
  actuators[Channel::n_bt] = 12.0;
  const Vec3<double> nu(0.41, 0.06, 0.03), eta(3.0, 4.0, 0.7);
  for (std::size_t type = 0; type < effect_catalogue().size(); ++type) {
    const EffectDescription& effect = effect_catalogue()[type];
    if (std::string_view name = effect.info.name;  // they act through the history of the inputs
        name == "actuator-delay" || name == "actuator-rate" || name == "actuator-lag")
      continue;
    std::vector<double> values;
    for (const EffectParameter& p : effect.parameters) values.push_back(plausible(p));
    const auto rate = [&]<typename T>(const std::vector<T>& parameters) {
      Effects<T> effects;
      effects.add(make_effect<T>(type, parameters, ship));
      const Model<T> model(ship, effects);
      const Inputs<T> inputs{actuators.cast<T>(), Vec2<T>(T(0.5), T(-0.9)), 20.0};
      const ShipState<T> change = rate_of_change(model, {eta.cast<T>(), nu.cast<T>()}, inputs);
      Eigen::Matrix<T, 6, 1> result;
      result << change.eta, change.nu;
      return result;
    };
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::string_view name = effect.parameters[i].name;
      if (name == "seed" || name == "t_start_s" || name == "t_end_s") continue;
      std::vector<Jet> jets(values.begin(), values.end());
      jets[i].v(0) = 1.0;
      const auto derivative = rate(jets);
      const double h = 1e-6 * std::max(1.0, std::abs(values[i]));
      std::vector<double> more = values, less = values;
      more[i] += h;
      less[i] -= h;
      const Eigen::Matrix<double, 6, 1> difference = (rate(more) - rate(less)) / (2.0 * h);
      for (Eigen::Index k = 0; k < 6; ++k) {
        CAPTURE(effect.info.name, name, k);
        CHECK_THAT(derivative(k).v(0), WithinAbs(difference(k), 1e-7 * (1.0 + std::abs(difference(k)))));
      }
    }
  }
}

TEST_CASE("steady current: the track is that in still water, carried along, to 1e-9 m", "[effects]") {
  // In calm air: wind would blow on a drifting ship.
  for (const char* name : {"esso-osaka-3m", "kvlcc2-l7"}) {
    Ship ship = read_ship(name);
    ship.wind.reset();
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
  ship.wind.reset();
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
  const WaterMotion<double> water = model.effects.water(at);
  const Vec2<double> nu_c = at.to_ship(water.velocity), a = at.to_ship(water.rate);
  const Vec3<double> nu_r(nu(0) - nu_c(0), nu(1) - nu_c(1), nu(2));
  const Vec3<double> F = model.modules.force(nu_r, now.actuators, Vec2<double>::Zero());
  CHECK(water.rate.norm() > 1e-3);
  check_moving_water(model.inertia, nu, rate, nu_c, a, F);
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
    return std::visit([&](const auto& m) { return m.force(wind); }, *model.modules.wind);
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

TEST_CASE("fouling: resistance ahead grows by its share", "[effects]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const Model<double> clean(ship), fouled(with(ship, "fouling", {{"resistance_increase", 0.25}}));
  const auto X = [](const Model<double>& model, double u) {
    return std::visit([&](const auto& hull) { return hull.force({u, 0.0, 0.0})(0); }, model.modules.hull);
  };
  CHECK_THAT(X(fouled, 0.5), WithinRel(1.25 * X(clean, 0.5), 1e-12));
  CHECK_THAT(X(fouled, -0.3), WithinRel(1.25 * X(clean, -0.3), 1e-12));
  const auto wake = [](const Model<double>& model) {
    return std::visit(
        [](const auto& m) {
          return 1.0 - m.flow({0.5, 0.0, 0.0}, 10.0).one_minus_w_P;
        },
        model.modules.propeller);
  };
  CHECK_THAT(wake(fouled) - wake(clean), WithinAbs(0.03 * 0.25, 1e-12));
}

TEST_CASE("draft: a deeper ship is heavier, and less of it stands in the wind", "[effects]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const Model<double> light(ship), deep(with(ship, "draft", {{"draft_change", 0.1}}));
  CHECK_THAT(deep.inertia.m, WithinRel(1.1 * light.inertia.m, 1e-12));
  CHECK_THAT(deep.inertia.I_z, WithinRel(1.1 * light.inertia.I_z, 1e-12));
  const auto& hull = std::get<UnifiedHull<double>>(deep.modules.hull).c;
  const auto& before = std::get<UnifiedHull<double>>(light.modules.hull).c;
  CHECK_THAT(hull.X_0F, WithinRel(1.1 * before.X_0F, 1e-12));
  CHECK_THAT(hull.N_v, WithinRel(1.1 * 1.1 * before.N_v, 1e-12));  // -k, and the scale 0.5 rho L d
  const double k = 2.0 * 0.20114 / 3.0, C_b = 0.27078 * 3.0 / (2.0 * 0.48925), a = 1.4 * C_b * 0.48925 / 3.0;
  CHECK_THAT(hull.Y_v, WithinRel(1.1 * before.Y_v * (0.55 * kPi * k + a) / (0.5 * kPi * k + a), 1e-12));
  CHECK_THAT(hull.N_r, WithinRel(1.1 * before.N_r * (-0.54 * 1.1 + 1.21 * k) / (-0.54 + k), 1e-12));
  const auto wind = [](const Model<double>& model) {
    return std::visit([](const auto& m) { return m.force({0.3, 1.7}); }, *model.modules.wind);
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
  CHECK_THAT(shallow.inertia.m_y, WithinRel(at.m_y * open.inertia.m_y, 1e-12));
  CHECK_THAT(shallow.inertia.m, WithinRel(open.inertia.m, 1e-15));
  const double I_zG = open.inertia.m * 0.0625 * 9.0;
  CHECK_THAT(shallow.inertia.I_z - I_zG, WithinRel(at.J_z * (open.inertia.I_z - I_zG), 1e-9));
}

TEST_CASE("shallow water: the ship turns wider, drifts less and keeps more speed", "[effects]") {
  Ship ship = read_ship("esso-osaka-3m");
  ship.wind.reset();
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
    return std::visit([&](const auto& h) { return h.force(nu); }, m.modules.hull);
  };
  const Model<double> drag(with(ship, "cross-flow-drag", {{"C_D_gain", 1.4}}));
  const Vec3<double> crab(0.0, 0.2, 0.0), ahead(0.5, 0.0, 0.0);
  CHECK_THAT(hull(drag, crab)(1), WithinRel(1.4 * hull(plain, crab)(1), 1e-12));
  CHECK_THAT(hull(drag, ahead)(0), WithinRel(hull(plain, ahead)(0), 1e-15));

  const auto flow = [](const Model<double>& m, double u) {
    return std::visit([&](const auto& p) { return p.flow({u, 0.02, 0.01}, 9.0); }, m.modules.propeller);
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
    return std::get<VectwinRudders<double>>(m.modules.rudder)
        .normal_forces({0.4, 0.02, 0.01}, flow(plain, 0.4), -0.5, 0.3);
  };
  CHECK_THAT(rudders(lost).port, WithinRel(0.45 * rudders(plain).port, 1e-12));
  CHECK_THAT(rudders(lost).starboard, WithinRel(0.9 * rudders(plain).starboard, 1e-12));

  Actuators<double> actuators;
  actuators[Channel::n_bt] = 20.0;
  const auto thruster = [&](const Model<double>& m, double u) {
    return std::visit([&](const auto& t) { return t.force({u, 0.0, 0.0}, actuators); }, m.modules.thrusters[0]);
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

TEST_CASE("actuator delay: the rudder acts later, in a maneuver and in the replay of its recording", "[effects]") {
  const Ship ship = read_ship("vectwin-3m"), late = with(ship, "actuator-delay", {{"delay_s", 1.25}});
  Trajectory recording = run(late, 60.0, 0.1);
  recording.file = "late.csv";
  // What is recorded is what the undelayed rudders do.
  CHECK(recording[Channel::delta_s] == run(ship, 60.0, 0.1)[Channel::delta_s]);
  const RecordedInputs inputs(recording, late, InputInterpolation::linear);
  const Trajectory again = replay(late, recording, inputs, {0.1, 0.1, 0.1});
  CHECK(largest_difference(again, recording, Channel::r) < 2e-4);
  CHECK(largest_difference(replay(ship, recording, inputs, {0.1, 0.1, 0.1}), recording, Channel::r) > 5e-3);
  CHECK(largest_difference(again, recording, Channel::delta_s) < 1e-12);

  // The rudder's angle of 1.25 s ago acts; before the start the first one.
  const RecordedInputs late_inputs = inputs.through({.delay_s = 1.25});
  const StepInputs<double> step = late_inputs.step(30.0, 0.1);
  CHECK_THAT(step.start.actuators[Channel::delta_p], WithinAbs(inputs.at(28.75).actuators[Channel::delta_p], 1e-12));
  CHECK_THAT(step.end.actuators[Channel::n_bt], WithinAbs(inputs.at(30.1).actuators[Channel::n_bt], 1e-12));
  CHECK(late_inputs.step(0.5, 0.1).start.actuators[Channel::delta_p] == recording[Channel::delta_p][0]);
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

TEST_CASE("effects: several add up", "[effects]") {
  const Ship ship = with(with(read_ship("vectwin-3m"), "body-force", {{"Y_N", 0.2}}), "earth-force",
                         {{"force_N", 0.5}, {"direction_deg", 90.0}});
  CHECK_THAT(Effects<double>(ship).force(at_heading(0.0))(1), WithinRel(0.7, 1e-12));
  const Ship both =
      with(with(read_ship("vectwin-3m"), "actuator-delay", {{"delay_s", 0.4}}), "actuator-delay", {{"delay_s", 0.5}});
  CHECK_THAT(Effects<double>(both).rudder_response().delay_s, WithinRel(0.9, 1e-12));
}

TEST_CASE("effects: what is wrong with an entry is said with its place", "[effects]") {
  const auto model = [](const std::string& ship, const std::string& type, const Parameters& parameters) {
    Model<double>(with(read_ship(ship), type, parameters));
  };
  CHECK_THROWS_WITH(model("vectwin-3m", "curent", {}),
                    Contains("ship.json: /effects/0/type: unknown effect 'curent'; known: steady-current"));
  CHECK_THROWS_WITH(model("vectwin-3m", "fouling", {{"increase", 0.2}}),
                    Contains("/effects/0/increase: unknown key; the effect 'fouling' has resistance_increase"));
  CHECK_THROWS_WITH(model("vectwin-3m", "steady-current", {{"current_speed_mps", 0.2}}),
                    Contains("/effects/0/current_set_deg: expected a number from -360 to 360"));
  CHECK_THROWS_WITH(model("vectwin-3m", "steady-current", {{"current_speed_mps", -0.2}, {"current_set_deg", 0.0}}),
                    Contains("expected a number >= 0 (speed of the water), got -0.2"));
  CHECK_THROWS_WITH(model("vectwin-3m", "thrust-loss", {{"k_T", std::nullopt}}),
                    Contains("/effects/0/k_T: expected a number >= 0 (factor on K_T), got null"));
  CHECK_THROWS_WITH(model("vectwin-3m", "shallow-water", {{"h_over_T", 1.0}}), Contains("expected a number >= 1.2"));
  CHECK_NOTHROW(model("vectwin-3m", "shallow-water", {{"h_over_T", std::nullopt}}));
  CHECK_THROWS_WITH(model("esso-osaka-3m", "rudder-effectiveness", {{"k_P", 0.5}}),
                    Contains("/effects/0: rudder-effectiveness: k_P and k_S belong to two rudders"));

  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& text) { return read_effects(folder.write("effect.json", text)); };
  CHECK(read(R"({"type": "wake", "wake_fraction_increase": 0.1, "source": "tow test"})").size() == 1);
  CHECK(read(R"([{"type": "wake", "wake_fraction_increase": 0.1}, {"type": "fouling", "resistance_increase": 0.1}])")
            .size() == 2);
  CHECK_THROWS_WITH(read(R"([{"type": "wake", "wake_fraction_increase": "large"}])"),
                    Contains("/0/wake_fraction_increase"));
  CHECK_THROWS_WITH(read(R"([3])"), Contains("/0"));
  CHECK_THROWS_AS(read(R"("wake")"), InputError);
}

TEST_CASE("effects: docs/effects.md is what the catalogue says", "[effects]") {
  std::ifstream file(std::string(LEEWAY_SOURCE_FOLDER) + "/docs/effects.md");
  std::stringstream page;
  page << file.rdbuf();
  CHECK(page.str() == catalogue_page());
}
