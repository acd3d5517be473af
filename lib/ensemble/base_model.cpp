#include "ensemble/base_model.hpp"

#include <cmath>
#include <filesystem>

#include <ceres/jet.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "io/files.hpp"
#include "ship/pitch_current.hpp"

namespace leeway::ensemble {
namespace {

using Dual = ceres::Jet<double, 4>;

// Velocity after a short step in calm air, from a state that is no special case of any effect.
Vec3<double> probe(const Model<double>& model, const Ship& ship, double t_s, const Vec3<double>& eta) {
  const double L = ship.particulars.L_pp, V = std::sqrt(kGravity_mps2 * L);
  Inputs<double> inputs{ship.initial_actuators(), Vec2<double>::Zero(), t_s};
  const ShipState<double> state{eta, Vec3<double>(0.1 * V, 0.01 * V, 0.02 * V / L)};
  return integrate(model, state, held_over<double>(inputs, 0.1 * L / V), 0.1 * L / V).nu;
}

}  // namespace

struct BaseModel::Duals {
  Model<Dual> model;
};

BaseModel::BaseModel(Ship ship, std::string text)
    : ship_(std::move(ship)),
      text_(std::move(text)),
      sha256_(io::sha256(text_)),
      model_(ship_),
      duals_(new Duals{Model<Dual>(ship_)}) {
  // What an effect depends on is found by trying it alone.
  for (const EffectEntry& entry : ship_.effects) {
    Ship alone = ship_;
    alone.effects = {entry};
    const Model<double> model(alone);
    const auto refuse = [&](const char* what) {
      return InputError(entry.file, 0, entry.pointer,
                        fmt::format("{}: a base model cannot have an effect that depends on {}", entry.type, what));
    };
    if (model.rudder_response() != RudderResponse()) throw refuse("what the rudders did before");
    const double L = ship_.particulars.L_pp;
    for (const double t_s : {0.0, 100.0, 1000.0}) {
      const Vec3<double> here = probe(model, alone, t_s, {0.0, 0.0, 0.3});
      if (probe(model, alone, t_s, {17.0 * L, -29.0 * L, 0.3}) != here) throw refuse("the place");
      for (const double psi : {1.4, 2.9, 4.7})
        if (probe(model, alone, t_s, {0.0, 0.0, psi}) != here) heading_effect_ = entry.type;
    }
  }
}

BaseModel::~BaseModel() = default;

std::shared_ptr<const BaseModel> BaseModel::read(const std::string& name_or_path) {
  const std::string path = io::find_config("ships", name_or_path);
  std::error_code error;
  if (path == "-" || (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error)))
    throw UsageError(fmt::format("--base: expected a file or a shipped name, got '{}'", name_or_path));
  std::string text = io::read_text(path);
  return std::make_shared<const BaseModel>(read_ship(path), std::move(text));
}

std::shared_ptr<const BaseModel> BaseModel::drawn(const ShipDraws& draws, int number, int& refused) const {
  ShipDraw draw = draws.draw(number);
  refused = draw.refused;
  const io::Json json = draws.json(io::parse_json(text_, ship_.file), draw, number);
  draw.ship.name = json.at("name").get<std::string>();
  return std::make_shared<const BaseModel>(std::move(draw.ship), io::to_text(json));
}

void BaseModel::check(const Trajectory& recording) const {
  const auto refuse = [&](Channel channel, const std::string& who) {
    return InputError(recording.file, 1, "", fmt::format("no column '{}', which {} needs", column_name(channel), who));
  };
  for (const Actuator& actuator : ship_.actuators)
    if (!actuator.is_optional && !recording.has(actuator.channel))
      throw refuse(actuator.channel, fmt::format("the base ship '{}'", ship_.name));
  if (!heading_effect_.empty() && !recording.has(Channel::psi))
    throw refuse(Channel::psi, fmt::format("the effect '{}' of the base ship '{}'", heading_effect_, ship_.name));
}

void BaseModel::prepare(std::vector<Trajectory>& recordings) const {
  add_revolutions(recordings, ship_);
  for (const Trajectory& recording : recordings) check(recording);
}

Inputs<double> BaseModel::inputs(const Samples& samples, const std::vector<Channel>& channels, Eigen::Index k) const {
  Inputs<double> in;
  for (std::size_t a = 0; a < channels.size(); ++a)
    in.actuators[channels[a]] = samples.actuators(static_cast<Eigen::Index>(a), k);
  in.true_wind = samples.true_wind.col(k);
  in.t_s = samples.t_s(k);
  return in;
}

ShipState<double> BaseModel::step(const ShipState<double>& state, const Inputs<double>& held, double dt_s) const {
  return integrate(model_, state, held_over<double>(held, dt_s), dt_s);
}

BaseModel::MeanRates BaseModel::mean_rates(const Vec3<double>& nu, double psi, const Inputs<double>& held,
                                           double dt_s) const {
  ShipState<Dual> state;
  for (int i = 0; i < 3; ++i) state.nu(i) = Dual(nu(i), i);
  state.eta(2) = Dual(psi, 3);
  const ShipState<Dual> end = integrate(duals_->model, state, held_over<Dual>(held, dt_s), dt_s);
  MeanRates result;
  for (int i = 0; i < 4; ++i) {
    const Dual rate = ((i < 3 ? end.nu(i) : end.eta(2)) - (i < 3 ? state.nu(i) : state.eta(2))) / dt_s;
    result.rates(i) = rate.a;
    result.derivatives.row(i) = rate.v.transpose();
  }
  return result;
}

}  // namespace leeway::ensemble
