#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/ship_draws.hpp"
#include "dynamics/simulation.hpp"
#include "recording/samples.hpp"

namespace leeway::ensemble {

/// Inputs that are held over a step of the base model.
template <typename T>
StepInputs<T> held_over(const Inputs<double>& in, double dt_s) {
  const auto at = [&](double h) {
    return Inputs<T>{in.actuators.template cast<T>(), Vec2<T>(in.true_wind.template cast<T>()), in.t_s + h};
  };
  return {at(0.0), at(0.5 * dt_s), at(dt_s)};
}

/// A ship's equations of motion as the part of the accelerations that is known beforehand; networks learn the rest:
///   nu' = f(nu, psi, actuators, true wind, t) + network(its inputs)
/// All inputs of f are held over a step. Effects of the ship take part, those that depend on the heading and on time
/// too; not those that depend on the place or on what the rudders did before, which a rollout does not know.
class BaseModel {
 public:
  /// text: the ship's JSON, which becomes part of the model directory. Throws InputError that points to an effect that
  /// cannot take part.
  BaseModel(Ship ship, std::string text);
  ~BaseModel();
  BaseModel(const BaseModel&) = delete;
  BaseModel& operator=(const BaseModel&) = delete;

  /// A path, or the name of a shipped ship. Throws UsageError for a pipe, which cannot be read twice, else as
  /// read_ship().
  static std::shared_ptr<const BaseModel> read(const std::string& name_or_path);

  /// Draw `number` of the ship, with the JSON that belongs to it.
  std::shared_ptr<const BaseModel> drawn(const ShipDraws& draws, int number, int& refused) const;

  const Ship& ship() const { return ship_; }
  const std::string& text() const { return text_; }
  const std::string& sha256() const { return sha256_; }
  const Model<double>& model() const { return model_; }

  /// Throws InputError if the recording lacks an actuator that is not optional, or the heading where an effect needs
  /// it.
  void check(const Trajectory& recording) const;
  /// add_revolutions() of the ship, then check().
  void prepare(std::vector<Trajectory>& recordings) const;

  /// The inputs of the step from point k; rows of samples.actuators are `channels`.
  Inputs<double> inputs(const Samples& samples, const std::vector<Channel>& channels, Eigen::Index k) const;

  /// State after a Runge-Kutta step with held inputs.
  ShipState<double> step(const ShipState<double>& state, const Inputs<double>& held, double dt_s) const;

  /// The same step as mean rates of (u, v_m, r, psi), over ground, and their derivatives by these at its start.
  struct MeanRates {
    Eigen::Vector4d rates;
    Eigen::Matrix4d derivatives;  ///< row: rate, column: state
  };
  MeanRates mean_rates(const Vec3<double>& nu, double psi, const Inputs<double>& held, double dt_s) const;

 private:
  struct Duals;

  Ship ship_;
  std::string text_, sha256_;
  Model<double> model_;
  std::unique_ptr<const Duals> duals_;
  std::string heading_effect_;  ///< the effect that needs the heading; empty if there is none
};

}  // namespace leeway::ensemble
