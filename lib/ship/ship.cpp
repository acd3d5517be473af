#include "ship/ship.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/linear_algebra.hpp"
#include "core/units.hpp"
#include "forces/registry.hpp"
#include "io/files.hpp"
#include "io/json.hpp"
#include "ship/plausibility.hpp"

namespace leeway {
namespace {

using io::JsonObject;
using io::kNotNegative;
using io::kPositive;

Particulars read_particulars(const JsonObject& json) {
  require_source(json);
  const Particulars p{json.number("L_pp_m", kPositive), json.number("B_m", kPositive), json.number("d_m", kPositive),
                      json.number("rho_kgpm3", kPositive)};
  json.check_all_known();
  return p;
}

InertiaCoefficients<double> read_inertia(const JsonObject& json) {
  require_source(json);
  const auto c = InertiaCoefficients<double>::read(json);
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

  const std::string unit = a.is_angle() ? "_deg" : "_rps";
  const double factor = a.is_angle() ? kDegree : 1.0;
  const double turns = std::numeric_limits<double>::infinity();
  const double min = a.turns_freely() ? -turns : json.number("min" + unit);
  const double max = a.turns_freely() ? turns : json.number("max" + unit);
  if (!(min < max)) json.fail("max" + unit, fmt::format("expected a number > {}, got {}", min, max));
  a.min = factor * min;
  a.max = factor * max;
  a.rate = factor * json.number(a.is_angle() ? "rate_degps" : "rate_rpsps", kPositive);
  a.time_constant_s = json.number("time_constant_s", kNotNegative);
  a.initial = factor * json.number("initial" + unit, {min, max});
  a.is_optional = json.flag_or("optional", false);
  if (a.is_optional && !a.is_thruster())
    json.fail("optional", fmt::format("a thruster can be optional, '{}' cannot", name));
  if (a.is_optional && a.initial != 0.0)
    json.fail("initial" + unit, fmt::format("expected 0, since an optional thruster is idle, got {}", a.initial));
  a.is_random = json.has("random_mean" + unit) || json.has("random_sd" + unit);
  if (a.is_random) {
    a.random_mean = factor * json.number("random_mean" + unit);
    a.random_sd = factor * json.number("random_sd" + unit, kNotNegative);
  }
  if (const auto current = json.object_if("pitch_current")) {
    if (a.channel != Channel::n_bt)
      json.fail("pitch_current", fmt::format("a bow thruster (n_bt) can have it, '{}' cannot", name));
    require_source(*current);
    a.n_at_pitch_current_1 = current->number("n_rps_at_1", kPositive);
    current->check_all_known();
  }
  json.check_all_known();
  return a;
}

PartSource source_of(const std::string& part, const JsonObject& json) {
  std::string source = json.text("source");
  if (const auto reversed = json.object_if("reversed")) source += "; reversed: " + reversed->text("source");
  return {part, json.text_or("type", ""), source};
}

// {"names": [...], "matrix": [[...]]}, and a source.
Ship::JointUncertainty read_joint_uncertainty(const JsonObject& json, const Ship& ship) {
  json.text_or("source", "");
  Ship::JointUncertainty joint{json.texts("names"), {}};
  const auto n = static_cast<Eigen::Index>(joint.names.size());
  for (std::size_t i = 0; i < joint.names.size(); ++i)
    if (std::count(joint.names.begin(), joint.names.begin() + static_cast<std::ptrdiff_t>(i), joint.names[i]) > 0)
      json.fail(fmt::format("names/{}", i), fmt::format("'{}' stands twice", joint.names[i]));
  const io::Json& rows = json.value("matrix");
  if (n == 0 || !rows.is_array() || static_cast<Eigen::Index>(rows.size()) != n)
    json.fail("matrix", fmt::format("expected a row for each of the {} names, and at least one", n));
  joint.matrix.resize(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const io::Json& row = rows[static_cast<std::size_t>(i)];
    const auto is_number = [](const io::Json& x) { return x.is_number() && std::isfinite(x.get<double>()); };
    if (!row.is_array() || static_cast<Eigen::Index>(row.size()) != n || !std::ranges::all_of(row, is_number))
      json.fail(fmt::format("matrix/{}", i), fmt::format("expected {} numbers", n));
    for (Eigen::Index j = 0; j < n; ++j) joint.matrix(i, j) = row[static_cast<std::size_t>(j)].get<double>();
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const io::Bounds sd = ship.is_absolute(joint.names[static_cast<std::size_t>(i)]) ? kAbsoluteSdRange : kLogSdRange;
    const double least = sd.low * sd.low, most = sd.high * sd.high;
    if (!(joint.matrix(i, i) >= least && joint.matrix(i, i) <= most))
      json.fail(fmt::format("matrix/{}/{}", i, i),
                fmt::format("expected a variance from {:g} to {:g}, got {}", least, most, joint.matrix(i, i)));
  }
  if (!joint.matrix.isApprox(joint.matrix.transpose(), 1e-9)) json.fail("matrix", "expected a symmetric matrix");
  // Of correlations, since the units of the names may differ.
  const Eigen::VectorXd per_sd = joint.matrix.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = per_sd.asDiagonal() * joint.matrix * per_sd.asDiagonal();
  if (Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation).eigenvalues().minCoeff() <
      -1e-9 * static_cast<double>(n))
    json.fail("matrix", "is no covariance: it gives a negative variance in some direction");
  json.check_all_known();
  return joint;
}

// A log-sd, or {"sd": s} in the coefficient's own unit.
Ship::Uncertainty read_uncertainty(const JsonObject& json, const std::string& name) {
  if (!json.value(name).is_object()) return {name, json.number(name, kLogSdRange)};
  const JsonObject absolute = json.object(name);
  const double sd = absolute.number("sd", kAbsoluteSdRange);
  absolute.check_all_known();
  return {name, sd, true};
}

// `coefficient_factors`, `coefficient_shifts`, `uncertainty`, `coefficient_covariance`, `coefficient_sources`.
void read_coefficients(const JsonObject& json, Ship& ship) {
  const auto each = [&](const char* key, const auto& read) {
    const auto object = json.object_if(key);
    if (!object) return;
    for (const std::string& name : object->keys())
      if (name == "source")
        object->text(name);
      else
        read(*object, name);
  };
  each("coefficient_factors", [&](const JsonObject& object, const std::string& name) {
    ship.multiply({{name, object.number(name, kFactorRange)}});
  });
  each("coefficient_shifts", [&](const JsonObject& object, const std::string& name) {
    ship.multiply({{name, 1.0, object.number(name)}});
  });
  each("uncertainty", [&](const JsonObject& object, const std::string& name) {
    ship.uncertainty.push_back(read_uncertainty(object, name));
  });
  each("coefficient_sources",
       [&](const JsonObject& object, const std::string& name) { ship.coefficient_sources[name] = object.text(name); });
  if (const auto covariance = json.object_if("coefficient_covariance"))
    ship.coefficient_covariance = read_joint_uncertainty(*covariance, ship);
}

// The channels that the force modules read.
std::vector<Channel> channels_of_modules(const Ship& ship) {
  std::vector<Channel> channels;
  const auto add = [&](const auto& c) { std::ranges::copy(c.channels(), std::back_inserter(channels)); };
  if (ship.modules->rudder) std::visit(add, *ship.modules->rudder);
  if (ship.modules->propeller) std::visit(add, *ship.modules->propeller);
  for (const auto& thruster : ship.modules->thrusters) std::visit(add, thruster);
  return channels;
}

void read_modules(const JsonObject& json, Ship& ship) {
  ship.modules->hull = HullModules::read(json.object("hull"));
  const std::vector<std::string> keys = json.keys();
  const auto is_there = [&](const char* key) { return std::ranges::find(keys, key) != keys.end(); };
  if (is_there("propeller") || is_there("rudder") || !is_there("thrusters")) {
    ship.modules->propeller = PropellerModules::read(json.object("propeller"));
    ship.modules->rudder = RudderModules::read(json.object("rudder"));
  }
  if (ship.has_twin_rudders() &&
      std::visit([](const auto& c) { return c.pitch_ratio; }, *ship.modules->propeller) == 0.0)
    json.object("propeller").fail("pitch_ratio", "missing, and the VecTwin rudders need it");
  if (json.has("thrusters"))
    for (const JsonObject& thruster : json.objects("thrusters"))
      ship.modules->thrusters.push_back(ThrusterModules::read(thruster));
  if (!ship.modules->has([]<typename M>() { return HasThrust<M>; }))
    json.object("propeller");  // says that it is missing
  if (const auto wind = json.object_if("wind")) ship.modules->wind = WindModules::read(*wind);

  for (const char* part : {"particulars", "inertia", "hull", "propeller", "rudder"})
    if (const auto object = json.object_if(part)) ship.sources.push_back(source_of(part, *object));
  if (json.has("thrusters"))
    for (const JsonObject& thruster : json.objects("thrusters"))
      ship.sources.push_back(source_of("thruster " + thruster.text("channel"), thruster));
  if (const auto wind = json.object_if("wind")) ship.sources.push_back(source_of("wind", *wind));
}

// Every channel that a module reads, each once.
void read_actuators(const JsonObject& json, Ship& ship) {
  ship.sources.push_back({"actuators", "", json.text_or("actuators_source", "")});
  for (const JsonObject& entry : json.objects("actuators")) {
    const Actuator actuator = read_actuator(entry);
    if (ship.find_actuator(actuator.channel) != nullptr)
      entry.fail("channel", fmt::format("'{}' stands twice", info(actuator.channel).name));
    ship.actuators.push_back(actuator);
    if (const auto current = entry.object_if("pitch_current"))
      ship.sources.push_back(source_of("pitch current", *current));
  }
  const std::vector<Channel> read = channels_of_modules(ship);
  for (const Channel channel : read)
    if (ship.find_actuator(channel) == nullptr)
      json.fail("actuators", fmt::format("no actuator '{}', which a force module reads", info(channel).name));
  for (const Actuator& actuator : ship.actuators)
    if (std::find(read.begin(), read.end(), actuator.channel) == read.end())
      json.fail("actuators", fmt::format("no force module reads '{}'", info(actuator.channel).name));
}

Ship read_whole(const JsonObject& json) {
  Ship ship;
  ship.file = json.file();
  ship.name = json.text("name");
  ship.description = json.text_or("description", "");
  ship.scale = json.number_or("scale", 1.0, kPositive);
  ship.particulars = read_particulars(json.object("particulars"));
  ship.inertia = read_inertia(json.object("inertia"));
  read_modules(json, ship);
  read_actuators(json, ship);
  if (json.has("effects"))
    for (const JsonObject& effect : json.objects("effects")) ship.effects.push_back(parse_effect(effect));
  read_coefficients(json, ship);
  if (const auto network = json.object_if("residual_network")) {
    ship.residual_network = std::make_shared<const ResidualNetwork>(residual_network_from(*network));
    for (const Channel channel : ship.residual_network->actuators)
      if (ship.find_actuator(channel) == nullptr)
        network->fail("inputs", fmt::format("the ship has no actuator '{}'", info(channel).name));
  }
  const auto* propeller =
      ship.modules->propeller ? std::get_if<StandardPropellerCoefficients<double>>(&*ship.modules->propeller) : nullptr;
  if (propeller != nullptr && !propeller->is_reversible && ship.find_actuator(Channel::n_p)->min < 0.0)
    json.fail("propeller", "turns astern by its actuator's limits, but has no object 'reversed'");
  ship.u0_mps = json.number("u0_mps");
  ship.random_interval_s = json.number("random_interval_s", kPositive);
  for (const char* key : {"scaling", "provenance"})
    if (json.has(key)) json.value(key);  // what made it, for people
  json.check_all_known();
  return ship;
}

}  // namespace

OwnModules::OwnModules() : modules_(std::make_unique<ModuleCoefficients>()) {}
OwnModules::~OwnModules() = default;
OwnModules::OwnModules(const OwnModules& other) : modules_(std::make_unique<ModuleCoefficients>(*other)) {}
OwnModules::OwnModules(OwnModules&& other) noexcept = default;
OwnModules& OwnModules::operator=(OwnModules other) noexcept {
  modules_ = std::move(other.modules_);
  return *this;
}

bool Ship::has_propeller() const { return modules->propeller.has_value(); }

bool Ship::has_rudders() const { return modules->rudder.has_value(); }

bool Ship::has_wind() const { return modules->wind.has_value(); }

bool Ship::has_twin_rudders() const {
  return modules->has([]<typename M>() { return HasTwinRudders<M>; });
}

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

std::vector<Actuator> Ship::propulsion() const {
  std::vector<Actuator> result;
  std::ranges::copy_if(actuators, std::back_inserter(result), &Actuator::is_propulsion);
  return result;
}

void Ship::order_propulsion(double n, Actuators<double>& command) const {
  for (const Actuator& actuator : propulsion()) command[actuator.channel] = n;
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
    if (found == coefficient_factors.end()) {
      coefficient_factors.push_back(by);
      continue;
    }
    found->factor *= by.factor;
    found->shift = found->shift * by.factor + by.shift;
  }
}

bool Ship::has_absolute_uncertainty() const { return std::ranges::any_of(uncertainty, &Uncertainty::is_absolute); }

bool Ship::is_absolute(std::string_view coefficient) const {
  return std::ranges::any_of(uncertainty, [&](const Uncertainty& u) { return u.is_absolute && u.name == coefficient; });
}

io::Json multiplied(io::Json ship, const std::vector<CoefficientFactor>& factors, const std::string& source) {
  const auto write = [&](const char* key, const std::string& name, double value) {
    io::Json& all = ship[key];
    if (all.is_null()) all = io::Json::object();
    all[name] = value;
    all["source"] = source;
  };
  const auto stated = [&](const char* key, const std::string& name, double otherwise) {
    const auto all = ship.find(key);
    return all == ship.end() ? otherwise : all->value(name, otherwise);
  };
  for (const CoefficientFactor& by : factors) {
    const double shift = stated("coefficient_shifts", by.name, 0.0) * by.factor + by.shift;
    if (by.factor != 1.0 || by.shift == 0.0)
      write("coefficient_factors", by.name, stated("coefficient_factors", by.name, 1.0) * by.factor);
    if (shift != 0.0) write("coefficient_shifts", by.name, shift);
  }
  return ship;
}

Ship read_ship(const std::string& name_or_path) {
  const std::string path = io::find_config("ships", name_or_path);
  Ship ship = parse_ship(io::read_json(path), path);
  tell_implausible(ship);
  return ship;
}

Ship parse_ship(const io::Json& text, const std::string& file) {
  JsonObject json(text, file);
  json.note_missing();
  Ship ship;
  try {
    ship = read_whole(json);
  } catch (const InputError&) {
    json.require_complete();  // what is wrong may follow from what is missing
    throw;
  }
  json.require_complete();
  return ship;
}

EffectEntry parse_effect(const JsonObject& json) {
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

std::vector<EffectEntry> read_effects(const std::string& path) {
  const io::Json text = io::read_json(path, io::JsonTop::object_or_array);
  std::vector<EffectEntry> effects;
  if (!text.is_array()) return {parse_effect(JsonObject(text, path))};
  for (std::size_t i = 0; i < text.size(); ++i)
    effects.push_back(parse_effect(JsonObject(text[i], path, fmt::format("/{}", i))));
  return effects;
}

}  // namespace leeway
