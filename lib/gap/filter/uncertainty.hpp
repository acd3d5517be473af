#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/coefficient_law.hpp"

namespace leeway::gap {

/// A coefficient, or a group of them, that is known up to a factor exp(theta), theta ~ N(0, sd^2), or where the ship's
/// file states an absolute uncertainty up to a difference theta.
struct UncertainParameter {
  std::string name;  ///< "hull.Y_v", "propeller.K_T", "wind.k_Y", ...
  double sd = 0.0;   ///< of theta
  bool is_absolute = false;
  std::optional<double> value = std::nullopt;  ///< of the coefficient as the ship has it; nothing of a group
  /// Whether it may be off by far more than stated and be no effect of the catalogue, which has a name.
  bool may_be_far_more = true, may_be_far_less = true;
  bool is_form = false;  ///< a term of another form of the same force, as far as published ones differ: never far off
  bool is_of_sensor = false;  ///< no coefficient but a number of a sensor's fault, in units of what is left open of it
};

/// What theta does to it.
CoefficientFactor changed(const UncertainParameter& parameter, double theta);

/// The uncertain parameters of a ship, coefficient_law() each by itself. Throws InputError for a name that the ship
/// does not have. The last one is no coefficient: kTiming.
std::vector<UncertainParameter> uncertain_parameters(const Ship& ship);

/// kTiming: without it, actuators sampled once a second look like late ones.
UncertainParameter timing_parameter();

/// Changes the parameters of a model by theta, in the order of uncertain_parameters(); the timing is left alone.
template <typename T, typename Theta>
void apply_uncertainty(Model<T>& model, const Theta& theta) {
  std::vector<T> changes(model.coefficients().size());
  for (std::size_t i = 0; i < changes.size(); ++i) changes[i] = T(theta[static_cast<Eigen::Index>(i)]);
  model.change_coefficients(changes);
}

}  // namespace leeway::gap
