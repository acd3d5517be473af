// The one unit that includes the registries of forces and effects, and compiles what they list.
#include "dynamics/model.hpp"

#include <type_traits>

#include <ceres/jet.h>

#include "dynamics/model_parts.hpp"
#include "dynamics/residual_network.hpp"

namespace leeway {

template <typename T>
Model<T>::Model(const Ship& ship) : parts_(std::make_unique<Parts>(ship, Effects<T>(ship))) {}

template <typename T>
Model<T>::Model(const Ship& ship, std::size_t effect, std::span<const T> values) {
  Effects<T> effects(ship);
  effects.add(make_effect<T>(effect, values, ship));
  parts_ = std::make_unique<Parts>(ship, std::move(effects));
}

template <typename T>
Model<T>::Model(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
template <typename T>
Model<T> Model<T>::without_effects(const Ship& ship) {
  return Model(std::make_unique<Parts>(ship, Effects<T>()));
}
template <typename T>
Model<T>::Model(const Model& other) : parts_(std::make_unique<Parts>(*other.parts_)) {}
template <typename T>
Model<T>::Model(Model&& other) noexcept = default;
template <typename T>
Model<T>& Model<T>::operator=(Model other) noexcept {
  parts_ = std::move(other.parts_);
  return *this;
}
template <typename T>
Model<T>::~Model() = default;

template <typename T>
Vec3<T> Model<T>::acceleration(const Vec3<T>& nu, const Actuators<T>& actuators, const Vec2<T>& apparent_wind) const {
  return parts_->inertia.acceleration(nu, parts_->modules.force(nu, actuators, apparent_wind));
}

template <typename T>
ModuleForces<T> Model<T>::forces(const Vec3<T>& nu, const Actuators<T>& actuators, const Vec2<T>& apparent_wind) const {
  return parts_->modules.forces(nu, actuators, apparent_wind);
}

template <typename T>
const RudderResponse& Model<T>::rudder_response() const {
  return parts_->effects.rudder_response();
}
template <typename T>
bool Model<T>::moves_water() const {
  return parts_->effects.moves_water();
}
template <typename T>
bool Model<T>::blows() const {
  return parts_->effects.blow();
}
template <typename T>
bool Model<T>::pushes() const {
  return parts_->effects.push();
}

template <typename T>
std::vector<Coefficient> Model<T>::coefficients() const {
  std::vector<Coefficient> result;
  Parts copy = *parts_;
  for_each_coefficient(
      copy.inertia, copy.modules,
      [&]<typename S>(const std::string& name, double log_sd, std::string_view reference, const S& scale) {
        Coefficient coefficient{name, log_sd, reference, std::nullopt, MovesBy<S, T>, kIsFormTerm<S>};
        if constexpr (std::is_same_v<T, double> && TellsValue<S>) coefficient.value = scale.value();
        result.push_back(coefficient);
      });
  return result;
}

template <typename T>
void Model<T>::change_coefficients(std::span<const T> theta) {
  using std::exp;
  std::size_t i = 0;
  for_each_coefficient(parts_->inertia, parts_->modules,
                       [&]<typename S>(const auto&, double, std::string_view, const S& scale) {
                         const bool moves = !parts_->moves.empty() && parts_->moves[i];
                         const T& by = theta[i++];
                         if constexpr (MovesBy<S, T>)
                           if (moves) return scale.move(by);
                         scale(T(exp(by)));
                       });
}

template <typename T>
std::vector<std::string> Model<T>::modules() const {
  return parts_->modules.names();
}
template <typename T>
bool Model<T>::is_of_wind(std::string_view module) const {
  return parts_->modules.is_of_wind(module);
}
template <typename T>
void Model<T>::scale_module(std::string_view module, const T& factor) {
  parts_->modules.scale(module, factor);
}

RudderResponse rudder_response_of(const Ship& ship) { return Effects<double>(ship).rudder_response(); }

template <typename T>
Vec3<T> water_velocity(const Model<T>& model, const Vec3<T>& eta, double t_s) {
  using std::cos, std::sin;
  Situation<T> at;
  at.t_s = t_s;
  at.eta = eta;
  at.cos_psi = cos(eta(2));
  at.sin_psi = sin(eta(2));
  const Vec2<T> nu_c = at.to_ship(model.parts().effects.water(at).velocity);
  return {nu_c(0), nu_c(1), T(0.0)};
}

template <typename T>
ShipState<T> rate_of_change(const Model<T>& model, const ShipState<T>& state, const Inputs<T>& inputs,
                            const ActingActuators<T>& acting) {
  using std::cos, std::sin;
  Situation<T> at;
  at.t_s = inputs.t_s;
  at.eta = state.eta;
  at.cos_psi = cos(state.eta(2));
  at.sin_psi = sin(state.eta(2));
  at.nu_water = at.nu_ground = state.nu;
  at.recorded_wind = inputs.true_wind;
  Vec2<T> true_wind = inputs.true_wind;
  Vec3<T> extra = Vec3<T>::Zero();  // forces besides those of the modules
  const Effects<T>& effects = model.parts().effects;
  if (effects.moves_water()) {
    const WaterMotion<T> water = effects.water(at);
    at.nu_ground.template head<2>() += at.to_ship(water.velocity);
    at.nu_water(2) -= water.turn(at);
    const Vec2<T> over_ground = at.to_earth(at.nu_ground.template head<2>());
    extra = model.parts().inertia.frame_force(at.to_ship(water.along_path(over_ground)));
  }
  if (effects.blow()) true_wind += effects.wind(at);
  std::optional<Actuators<T>> changed;
  if (effects.act()) {
    changed = inputs.actuators;
    effects.act(*changed);
  }
  if (effects.push()) {
    at.actuators = changed ? &*changed : &acting.actuators;
    extra += effects.force(at);
  }

  if (model.parts().residual_network)
    extra +=
        model.parts().inertia.force_of(acceleration<T>(*model.parts().residual_network, at.nu_ground, inputs.actuators,
                                                       at.to_ship(inputs.true_wind) + at.nu_ground.template head<2>()));

  const T &u = at.nu_ground(0), &v_m = at.nu_ground(1);
  const Vec2<T> apparent_wind = at.to_ship(true_wind) + at.nu_ground.template head<2>();
  const Vec3<T> force = changed ? model.parts().modules.force(at.nu_water, *changed, apparent_wind)
                                : model.parts().modules.force(at.nu_water, acting, apparent_wind);
  return {Vec3<T>(u * at.cos_psi - v_m * at.sin_psi, u * at.sin_psi + v_m * at.cos_psi, state.nu(2)),
          model.parts().inertia.acceleration(state.nu, force + extra)};
}

template <typename T>
ShipState<T> rate_of_change(const Model<T>& model, const ShipState<T>& state, const Inputs<T>& inputs) {
  return rate_of_change(model, state, inputs, ActingActuators<T>(inputs.actuators));
}

template <typename T>
ShipState<T> integrate_through_water(const Model<T>& model, const ShipState<T>& state, const StepInputs<T>& inputs,
                                     double dt_s, Integrator integrator) {
  const auto moved = [&](const ShipState<T>& rate, double h) {
    return ShipState<T>{state.eta + h * rate.eta, state.nu + h * rate.nu};
  };
  const ActingActuators<T> start(inputs.start.actuators);
  const ShipState<T> k1 = rate_of_change(model, state, inputs.start, start);
  if (integrator == Integrator::euler) return moved(k1, dt_s);
  const ActingActuators<T> middle(inputs.middle.actuators, start);
  const ShipState<T> k2 = rate_of_change(model, moved(k1, dt_s / 2.0), inputs.middle, middle);
  const ShipState<T> k3 = rate_of_change(model, moved(k2, dt_s / 2.0), inputs.middle, middle);
  const ActingActuators<T> end(inputs.end.actuators, middle);
  const ShipState<T> k4 = rate_of_change(model, moved(k3, dt_s), inputs.end, end);
  return {state.eta + dt_s / 6.0 * (k1.eta + 2.0 * k2.eta + 2.0 * k3.eta + k4.eta),
          state.nu + dt_s / 6.0 * (k1.nu + 2.0 * k2.nu + 2.0 * k3.nu + k4.nu)};
}

template <typename T>
ShipState<T> integrate(const Model<T>& model, const ShipState<T>& over_ground, const StepInputs<T>& inputs, double dt_s,
                       Integrator integrator) {
  if (model.moves_water()) {
    ShipState<T> state = over_ground;
    state.nu -= water_velocity(model, state.eta, inputs.start.t_s);
    state = integrate_through_water(model, state, inputs, dt_s, integrator);
    state.nu += water_velocity(model, state.eta, inputs.end.t_s);
    return state;
  }
  return integrate_through_water(model, over_ground, inputs, dt_s, integrator);
}

namespace {

template <std::size_t... i>
std::vector<EffectDescription> describe(std::index_sequence<i...>) {
  return {EffectDescription{std::variant_alternative_t<i, Effect<double>>::info,
                            std::variant_alternative_t<i, Effect<double>>::parameters}...};
}

}  // namespace

const std::vector<EffectDescription>& effect_catalogue() {
  static const std::vector<EffectDescription> catalogue =
      describe(std::make_index_sequence<std::variant_size_v<Effect<double>>>());
  return catalogue;
}

void require_applicable(std::size_t type, std::span<const double> values, const Ship& ship) {
  make_effect<double>(type, values, ship);
}

#define LEEWAY_MODEL_OF(...)                                                                                       \
  template class Model<__VA_ARGS__>;                                                                               \
  template Vec3<__VA_ARGS__> water_velocity(const Model<__VA_ARGS__>&, const Vec3<__VA_ARGS__>&, double);          \
  template ShipState<__VA_ARGS__> rate_of_change(const Model<__VA_ARGS__>&, const ShipState<__VA_ARGS__>&,         \
                                                 const Inputs<__VA_ARGS__>&, const ActingActuators<__VA_ARGS__>&); \
  template ShipState<__VA_ARGS__> rate_of_change(const Model<__VA_ARGS__>&, const ShipState<__VA_ARGS__>&,         \
                                                 const Inputs<__VA_ARGS__>&);                                      \
  template ShipState<__VA_ARGS__> integrate(const Model<__VA_ARGS__>&, const ShipState<__VA_ARGS__>&,              \
                                            const StepInputs<__VA_ARGS__>&, double, Integrator);
LEEWAY_MODEL_OF(double)
LEEWAY_MODEL_OF(ceres::Jet<double, 4>)   // base models of ensembles: by velocity and heading
LEEWAY_MODEL_OF(ceres::Jet<double, 8>)   // filter: by state and the wind's error
LEEWAY_MODEL_OF(ceres::Jet<double, 16>)  // filter: by coefficients, sixteen at a time
#undef LEEWAY_MODEL_OF

}  // namespace leeway
