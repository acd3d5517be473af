#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/wind.hpp"
#include "dynamics/integrator.hpp"
#include "dynamics/state.hpp"
#include "effects/rudder_response.hpp"
#include "forces/module_forces.hpp"
#include "ship/ship.hpp"

namespace leeway {

/// A coefficient of a ship, or a group of them, that is known up to a factor; names as in coefficient_factors.
struct Coefficient {
  std::string name;
  double log_sd = 0.0;  ///< sd of its natural logarithm unless the ship's JSON states another
  std::string_view reference;
  std::optional<double> value;  ///< as the model has it; nothing of a group
  bool can_move = false;        ///< a single number, which a difference can change
  bool is_form = false;         ///< a term of another form of the same force: forces/coefficient_list.hpp
};

/// A ship: mass, force modules and effects. T is double, or an autodiff scalar for derivatives by state, actuators or,
/// after they were multiplied, coefficients of the modules. Instantiated in model.cpp for double and ceres::Jet<double,
/// n> with n = 4, 8 and 16, and for nothing else: so no other source compiles the modules and effects.
template <typename T>
class Model {
 public:
  struct Parts;  ///< inertia, modules, effects: model_parts.hpp

  /// With the effects of the ship. Throws InputError for a coefficient factor that the ship has not, and for whatever
  /// is wrong with an entry of its effects.
  explicit Model(const Ship& ship);
  /// With one effect more: its place in the catalogue, and values in the catalogue's order and units. Throws
  /// EffectNotApplicable if the ship lacks what it needs.
  Model(const Ship& ship, std::size_t effect, std::span<const T> values);
  static Model without_effects(const Ship& ship);
  Model(const Model& other);
  Model(Model&& other) noexcept;
  Model& operator=(Model other) noexcept;
  ~Model();

  /// (du/dt, dv_m/dt, dr/dt) at midship in water at rest, without what effects do during a run.
  ///   nu             (u, v_m [m/s], r [rad/s]) at midship
  ///   actuators      actual values
  ///   apparent_wind  in ship axes [m/s], pointing to where it comes from: apparent_wind() of core/wind.hpp
  Vec3<T> acceleration(const Vec3<T>& nu, const Actuators<T>& actuators, const Vec2<T>& apparent_wind) const;
  /// The forces by module, under the same.
  ModuleForces<T> forces(const Vec3<T>& nu, const Actuators<T>& actuators, const Vec2<T>& apparent_wind) const;

  const RudderResponse& rudder_response() const;
  /// Whether effects move the water, add to the wind, or push, during a run.
  bool moves_water() const;
  bool blows() const;
  bool pushes() const;

  /// What is known up to a factor, always in the same order.
  std::vector<Coefficient> coefficients() const;
  /// Changes them, in that order: multiplied by exp(theta), or where the ship's file states an absolute uncertainty
  /// moved by theta, in the coefficient's own unit.
  void change_coefficients(std::span<const T> theta);
  /// The groups of modules whose force has a scale: "hull", and where the ship has them "propeller", "rudder",
  /// "thruster", "wind".
  std::vector<std::string> modules() const;
  /// Whether the force of one of them is of the wind.
  bool is_of_wind(std::string_view module) const;
  /// Multiplies the force of one of them (a propeller's thrust, a rudder's normal force).
  void scale_module(std::string_view module, const T& factor);

  const Parts& parts() const { return *parts_; }
  Parts& parts() { return *parts_; }

 private:
  explicit Model(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

/// How the rudders of a ship follow what is recorded of them. Throws what Model(ship) throws of effects.
RudderResponse rudder_response_of(const Ship& ship);

/// Velocity of the water at the ship, in ship axes [m/s].
template <typename T>
Vec3<T> water_velocity(const Model<T>& model, const Vec3<T>& eta, double t_s);

/// d(eta, nu)/dt; nu is the velocity through the water, which is that over ground unless an effect moves the water.
///   acting  the actuators of `inputs`
template <typename T>
ShipState<T> rate_of_change(const Model<T>& model, const ShipState<T>& state, const Inputs<T>& inputs,
                            const ActingActuators<T>& acting);
template <typename T>
ShipState<T> rate_of_change(const Model<T>& model, const ShipState<T>& state, const Inputs<T>& inputs);

/// One step of the classical Runge-Kutta method of fourth order, or of Euler's method, which uses `start` alone. The
/// state's velocity is over ground. In moving water the step is taken with the velocity through the water, so that a
/// steady current carries the track along to rounding.
template <typename T>
ShipState<T> integrate(const Model<T>& model, const ShipState<T>& over_ground, const StepInputs<T>& inputs, double dt_s,
                       Integrator integrator = Integrator::rk4);

}  // namespace leeway
