#include "ship/ship.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "core/units.hpp"
#include "io/files.hpp"
#include "io/json.hpp"

namespace leeway {
namespace {

using io::JsonObject;
using io::kNotNegative;
using io::kPositive;

template <std::size_t n>
std::array<double, n> polynomial(const JsonObject& json, const std::string& key) {
  const std::vector<double> numbers = json.numbers(key, n);
  std::array<double, n> result{};
  std::copy(numbers.begin(), numbers.end(), result.begin());
  return result;
}

// Each module says where its numbers come from.
void require_source(const JsonObject& module) {
  if (module.text("source").empty()) module.fail("source", "expected where the numbers come from, got nothing");
}

Particulars read_particulars(const JsonObject& json) {
  require_source(json);
  const Particulars p{json.number("L_pp_m", kPositive), json.number("B_m", kPositive), json.number("d_m", kPositive),
                      json.number("rho_kgpm3", kPositive)};
  json.check_all_known();
  return p;
}

InertiaCoefficients<double> read_inertia(const JsonObject& json) {
  require_source(json);
  const InertiaCoefficients<double> c{json.number("m", kPositive), json.number("x_G", {-0.5, 0.5}),
                                      json.number("m_x", kNotNegative), json.number("m_y", kNotNegative),
                                      json.number("I_zG_plus_J_z", kPositive)};
  json.check_all_known();
  return c;
}

HullCoefficients read_hull(const JsonObject& json) {
  const std::string type = json.word("type", {"unified-2009", "mmg-standard"});
  require_source(json);
  if (type == "mmg-standard") {
    const StandardHullCoefficients<double> c{json.number("R_0", kNotNegative),
                                             json.number("X_vv"),
                                             json.number("X_vr"),
                                             json.number("X_rr"),
                                             json.number("X_vvvv"),
                                             json.number("Y_v"),
                                             json.number("Y_r"),
                                             json.number("Y_vvv"),
                                             json.number("Y_vvr"),
                                             json.number("Y_vrr"),
                                             json.number("Y_rrr"),
                                             json.number("N_v"),
                                             json.number("N_r"),
                                             json.number("N_vvv"),
                                             json.number("N_vvr"),
                                             json.number("N_vrr"),
                                             json.number("N_rrr")};
    json.check_all_known();
    return c;
  }
  const UnifiedHullCoefficients<double> c{
      json.number("X_0F"), json.number("X_0A"), json.number("X_vr"), json.number("Y_v"),  json.number("Y_r"),
      json.number("N_v"),  json.number("N_r"),  json.number("C_D"),  json.number("C_rY"), json.number("C_rN")};
  json.check_all_known();
  return c;
}

StandardPropellerCoefficients<double> read_standard_propeller(const JsonObject& json) {
  StandardPropellerCoefficients<double> c{};
  c.D_P = json.number("D_P_m", kPositive);
  c.x_P = json.number("x_P", {-0.6, 0.6});
  c.pitch_ratio = json.number_or("pitch_ratio", 0.0, kPositive);
  c.K_T = polynomial<3>(json, "K_T");
  c.t_P = json.number("t_P", {0.0, 1.0});
  c.w_P0 = json.number("w_P0", {0.0, 1.0});
  c.C_1 = json.number("C_1", kNotNegative);
  c.C_2_negative = json.number("C_2_negative", kPositive);
  c.C_2_positive = json.number("C_2_positive", kPositive);
  if (const auto reversed = json.object_if("reversed")) {
    require_source(*reversed);
    c.is_reversible = true;
    c.K_T_reversed = polynomial<2>(*reversed, "K_T");
    c.K_T_reversed_low = reversed->number("K_T_low");
    c.J_s_reversed = reversed->number("J_s", {-10.0, 0.0});
    reversed->check_all_known();
  }
  json.check_all_known();
  return c;
}

PropellerCoefficients read_propeller(const JsonObject& json) {
  const std::string type = json.word("type", {"kang-2008", "four-quadrant", "mmg-standard"});
  require_source(json);
  if (type == "mmg-standard") return read_standard_propeller(json);
  const double D_P = json.number("D_P_m", kPositive), pitch_ratio = json.number("pitch_ratio", kPositive);
  const double x_P = json.number("x_P", {-0.6, 0.6});
  if (type == "kang-2008") {
    const double v_P_sign = json.word("v_P", {"v - x_P r", "v + x_P r"}) == "v + x_P r" ? 1.0 : -1.0;
    const KangPropellerCoefficients<double> c{D_P,
                                              pitch_ratio,
                                              x_P,
                                              v_P_sign,
                                              polynomial<3>(json, "K_T_ahead"),
                                              polynomial<3>(json, "K_T_astern"),
                                              polynomial<3>(json, "a"),
                                              polynomial<3>(json, "b"),
                                              polynomial<3>(json, "c"),
                                              polynomial<3>(json, "d")};
    json.check_all_known();
    return c;
  }
  const FourQuadrantPropellerCoefficients<double> c{D_P,
                                                    pitch_ratio,
                                                    x_P,
                                                    polynomial<3>(json, "K_T"),
                                                    json.number("t_P", {0.0, 1.0}),
                                                    polynomial<3>(json, "w_P"),
                                                    polynomial<2>(json, "K_T_reversed"),
                                                    json.number("K_T_reversed_low"),
                                                    json.number("J_s_reversed", {-10.0, 0.0}),
                                                    polynomial<3>(json, "Y_backing"),
                                                    polynomial<3>(json, "N_backing"),
                                                    polynomial<2>(json, "J_s_walk"),
                                                    polynomial<2>(json, "Y_walk_low"),
                                                    polynomial<2>(json, "Y_walk_middle"),
                                                    polynomial<2>(json, "N_walk_low"),
                                                    polynomial<2>(json, "N_walk_middle"),
                                                    json.number("Y_walk_high"),
                                                    json.number("N_walk_high")};
  if (!(c.J_s_walk[0] < c.J_s_walk[1])) json.fail("J_s_walk", "expected two increasing numbers");
  json.check_all_known();
  return c;
}

RudderCoefficients read_rudder(const JsonObject& json) {
  const std::string type = json.word("type", {"vectwin-kang-2008", "single", "mmg-standard"});
  require_source(json);
  const double A_R = json.number("A_R_m2", kPositive), x_R = json.number("x_R_m"),
               t_R = json.number("t_R", {-1.0, 1.0});
  if (type == "mmg-standard") {
    const StandardRudderCoefficients<double> c{A_R,
                                               json.number("H_R_m", kPositive),
                                               x_R,
                                               t_R,
                                               json.number("a_H"),
                                               json.number("x_H"),
                                               json.number("l_R"),
                                               json.number("epsilon", kPositive),
                                               json.number("kappa", kNotNegative),
                                               json.number("gamma_R_negative"),
                                               json.number("gamma_R_positive"),
                                               json.number("f_alpha", kPositive),
                                               json.number("k_reversed", kNotNegative)};
    json.check_all_known();
    return c;
  }
  const double aspect_ratio = json.number("aspect_ratio", kPositive);
  const double k_x = json.number("k_x", kPositive);
  if (type == "vectwin-kang-2008") {
    json.check_all_known();
    return VectwinRuddersCoefficients<double>{A_R, aspect_ratio, x_R, t_R, k_x};
  }
  const SingleRudderCoefficients<double> c{A_R,
                                           aspect_ratio,
                                           x_R,
                                           t_R,
                                           json.number("a_H"),
                                           json.number("x_H"),
                                           json.number("l_R"),
                                           json.number("epsilon", kPositive),
                                           k_x,
                                           json.number("gamma_R_negative"),
                                           json.number("gamma_R_positive"),
                                           json.number("f_alpha", kPositive),
                                           json.number("k_reversed", kNotNegative),
                                           json.number("k_hull_wake", kNotNegative)};
  json.check_all_known();
  return c;
}

ThrusterCoefficients read_thruster(const JsonObject& json) {
  json.word("type", {"kobayashi-1988"});
  require_source(json);
  const Channel channel = json.word("channel", {"n_bt", "n_st"}) == "n_bt" ? Channel::n_bt : Channel::n_st;
  const SideThrusterCoefficients<double> c{channel,
                                           json.number("D_m", kPositive),
                                           json.number("x_m"),
                                           json.number("K_T_positive", kNotNegative),
                                           json.number("K_T_negative", {-10.0, 0.0}),
                                           polynomial<3>(json, "a_Y"),
                                           polynomial<3>(json, "a_N"),
                                           json.number("u_max_mps", kPositive)};
  json.check_all_known();
  return c;
}

WindCoefficients read_wind(const JsonObject& json) {
  json.word("type", {"fujiwara-1998"});
  require_source(json);
  const FujiwaraWindGeometry c{json.number("rho_air_kgpm3", kPositive),
                               json.number("B_m", kPositive),
                               json.number("A_T_m2", kPositive),
                               json.number("A_L_m2", kPositive),
                               json.number("A_OD_m2", kPositive),
                               json.number("C_m"),
                               json.number("C_BR_m"),
                               json.number("H_BR_m", kPositive),
                               json.number("H_C_m", kPositive)};
  json.check_all_known();
  return c;
}

Actuator read_actuator(const JsonObject& json) {
  std::vector<std::string> names;
  for (const Channel channel : kActuatorChannels)
    if (channel != Channel::i_bt) names.emplace_back(info(channel).name);
  const std::string name = json.word("channel", names);
  Actuator a;
  for (const Channel channel : kActuatorChannels)
    if (info(channel).name == name) a.channel = channel;

  const std::string unit = a.is_rudder() ? "_deg" : "_rps";
  const double factor = a.is_rudder() ? kDegree : 1.0;
  const double min = json.number("min" + unit), max = json.number("max" + unit);
  if (!(min < max)) json.fail("max" + unit, fmt::format("expected a number > {}, got {}", min, max));
  a.min = factor * min;
  a.max = factor * max;
  a.rate = factor * json.number(a.is_rudder() ? "rate_degps" : "rate_rpsps", kPositive);
  a.time_constant_s = json.number("time_constant_s", kNotNegative);
  a.initial = factor * json.number("initial" + unit, {min, max});
  a.is_optional = json.flag_or("optional", false);
  if (a.is_optional && a.channel != Channel::n_bt && a.channel != Channel::n_st)
    json.fail("optional", fmt::format("a thruster can be optional, '{}' cannot", name));
  if (a.is_optional && a.initial != 0.0)
    json.fail("initial" + unit, fmt::format("expected 0, since an optional thruster is idle, got {}", a.initial));
  a.is_random = json.has("random_mean" + unit) || json.has("random_sd" + unit);
  if (a.is_random) {
    a.random_mean = factor * json.number("random_mean" + unit);
    a.random_sd = factor * json.number("random_sd" + unit, kNotNegative);
  }
  json.check_all_known();
  return a;
}

EffectEntry read_effect(const JsonObject& json) {
  EffectEntry entry{json.text("type"), {}, json.file(), json.pointer("")};
  entry.pointer.pop_back();  // the slash
  for (const std::string& key : json.keys()) {
    if (key == "type") continue;
    if (key == "description" || key == "source")
      json.text(key);
    else if (json.value(key).is_null())
      entry.parameters.emplace_back(key, std::nullopt);
    else
      entry.parameters.emplace_back(key, json.number(key));
  }
  return entry;
}

PartSource source_of(const std::string& part, const JsonObject& json) {
  std::string source = json.text("source");
  if (const auto reversed = json.object_if("reversed")) source += "; reversed: " + reversed->text("source");
  return {part, json.text_or("type", ""), source};
}

// The channels that the force modules read.
std::vector<Channel> channels_of_modules(const Ship& ship) {
  std::vector<Channel> channels;
  if (ship.has_twin_rudders())
    channels = {Channel::delta_p, Channel::delta_s};
  else
    channels = {Channel::delta};
  channels.push_back(Channel::n_p);
  for (const ThrusterCoefficients& thruster : ship.thrusters)
    channels.push_back(std::visit([](const auto& c) { return c.channel; }, thruster));
  return channels;
}

}  // namespace

const Actuator* Ship::find_actuator(Channel channel) const {
  const auto found =
      std::find_if(actuators.begin(), actuators.end(), [&](const auto& a) { return a.channel == channel; });
  return found == actuators.end() ? nullptr : &*found;
}

std::vector<Channel> Ship::actuator_channels() const {
  std::vector<Channel> channels;
  for (const Actuator& actuator : actuators) channels.push_back(actuator.channel);
  return channels;
}

Actuators<double> Ship::initial_actuators() const {
  Actuators<double> result;
  for (const Actuator& actuator : actuators) result[actuator.channel] = actuator.initial;
  return result;
}

void Ship::multiply(const std::vector<CoefficientFactor>& factors) {
  for (const CoefficientFactor& by : factors) {
    const auto found = std::find_if(coefficient_factors.begin(), coefficient_factors.end(),
                                    [&](const CoefficientFactor& own) { return own.name == by.name; });
    if (found == coefficient_factors.end())
      coefficient_factors.push_back(by);
    else
      found->factor *= by.factor;
  }
}

Ship read_ship(const std::string& name_or_path) {
  const std::string path = io::find_config("ships", name_or_path);
  const io::Json text = io::read_json(path);
  const JsonObject json(text, path);
  Ship ship;
  ship.file = path;
  ship.name = json.text("name");
  ship.description = json.text_or("description", "");
  ship.scale = json.number_or("scale", 1.0, kPositive);
  ship.particulars = read_particulars(json.object("particulars"));
  ship.inertia = read_inertia(json.object("inertia"));
  ship.hull = read_hull(json.object("hull"));
  ship.propeller = read_propeller(json.object("propeller"));
  ship.rudder = read_rudder(json.object("rudder"));
  if (std::holds_alternative<VectwinRuddersCoefficients<double>>(ship.rudder) &&
      std::visit([](const auto& c) { return c.pitch_ratio; }, ship.propeller) == 0.0)
    json.object("propeller").fail("pitch_ratio", "missing, and the VecTwin rudders need it");
  if (json.has("thrusters"))
    for (const JsonObject& thruster : json.objects("thrusters")) ship.thrusters.push_back(read_thruster(thruster));
  if (const auto wind = json.object_if("wind")) ship.wind = read_wind(*wind);

  for (const char* part : {"particulars", "inertia", "hull", "propeller", "rudder"})
    ship.sources.push_back(source_of(part, json.object(part)));
  if (json.has("thrusters"))
    for (const JsonObject& thruster : json.objects("thrusters"))
      ship.sources.push_back(source_of("thruster " + thruster.text("channel"), thruster));
  if (const auto wind = json.object_if("wind")) ship.sources.push_back(source_of("wind", *wind));
  ship.sources.push_back({"actuators", "", json.text_or("actuators_source", "")});
  for (const JsonObject& entry : json.objects("actuators")) {
    const Actuator actuator = read_actuator(entry);
    if (ship.find_actuator(actuator.channel) != nullptr)
      entry.fail("channel", fmt::format("'{}' stands twice", info(actuator.channel).name));
    ship.actuators.push_back(actuator);
  }
  const std::vector<Channel> read = channels_of_modules(ship);
  for (const Channel channel : read)
    if (ship.find_actuator(channel) == nullptr)
      json.fail("actuators", fmt::format("no actuator '{}', which a force module reads", info(channel).name));
  for (const Actuator& actuator : ship.actuators)
    if (std::find(read.begin(), read.end(), actuator.channel) == read.end())
      json.fail("actuators", fmt::format("no force module reads '{}'", info(actuator.channel).name));
  if (json.has("effects"))
    for (const JsonObject& effect : json.objects("effects")) ship.effects.push_back(read_effect(effect));
  if (const auto factors = json.object_if("coefficient_factors"))
    for (const std::string& name : factors->keys())
      if (name != "source") ship.coefficient_factors.push_back({name, factors->number(name, {0.01, 100.0})});
  if (const auto network = json.object_if("residual_network")) {
    ship.residual_network = std::make_shared<const ResidualNetwork>(residual_network_from(*network));
    for (const Channel channel : ship.residual_network->actuators)
      if (ship.find_actuator(channel) == nullptr)
        network->fail("inputs", fmt::format("the ship has no actuator '{}'", info(channel).name));
  }
  if (const auto uncertainty = json.object_if("uncertainty"))
    for (const std::string& name : uncertainty->keys())
      ship.uncertainty.push_back({name, uncertainty->number(name, {1e-4, 3.0})});
  const auto* propeller = std::get_if<StandardPropellerCoefficients<double>>(&ship.propeller);
  if (propeller != nullptr && !propeller->is_reversible && ship.find_actuator(Channel::n_p)->min < 0.0)
    json.fail("propeller", "turns astern by its actuator's limits, but has no object 'reversed'");
  ship.u0_mps = json.number("u0_mps");
  ship.random_interval_s = json.number("random_interval_s", kPositive);
  json.check_all_known();
  return ship;
}

std::vector<EffectEntry> read_effects(const std::string& path) {
  const io::Json text = io::read_json(path);
  std::vector<EffectEntry> effects;
  if (!text.is_array()) return {read_effect(JsonObject(text, path))};
  for (std::size_t i = 0; i < text.size(); ++i)
    effects.push_back(read_effect(JsonObject(text[i], path, fmt::format("/{}", i))));
  return effects;
}

}  // namespace leeway
