#include <fstream>
#include <sstream>

#include <catch2/catch.hpp>
#include <ceres/jet.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/model_parts.hpp"
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
      double most =
          largest_difference(changed, without, Channel::u) + largest_difference(changed, without, Channel::vm);
      if (effect.info.name == "rudder-latency")  // it changes what is recorded of the rudders alone
        most = largest_difference(changed, without, ship.has_twin_rudders() ? Channel::delta_s : Channel::delta);
      CHECK(most > 1e-5);
      for (const double x : changed[Channel::x0]) CHECK(std::isfinite(x));
    }
  }
}

TEST_CASE("effects: derivatives by the parameters agree with central differences", "[effects]") {
  using Jet = ceres::Jet<double, 4>;
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
        name == "actuator-delay" || name == "actuator-rate" || name == "actuator-lag" || name == "rudder-latency")
      continue;
    std::vector<double> values;
    for (const EffectParameter& p : effect.parameters) values.push_back(plausible(p));
    const auto rate = [&]<typename T>(const std::vector<T>& parameters) {
      const Model<T> model(ship, type, parameters);
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
  CHECK_THROWS_WITH(
      model("vectwin-3m", "tug", {{"force_N", 1.0}, {"direction_deg", 0.0}, {"t_start_s", 9.0}, {"t_end_s", 5.0}}),
      Contains("/effects/0/t_end_s: expected more than t_start_s = 9, got 5"));

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
  std::ifstream file(LEEWAY_SOURCE_FOLDER "/docs/effects.md");
  std::stringstream page;
  page << file.rdbuf();
  CHECK(page.str() == catalogue_page());
}
