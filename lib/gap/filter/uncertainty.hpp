#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "dynamics/coefficient_law.hpp"

namespace leeway::gap {

/// A coefficient, or a group of them, that is known up to a factor exp(theta), theta ~ N(0, log_sd^2).
struct UncertainParameter {
  std::string name;  ///< "hull.Y_v", "propeller.K_T", "wind.k_Y", ...
  double log_sd = 0.0;
  /// What is still called a wrong coefficient and not missing physics: twice log_sd, and at least 0.2 unless the ship's
  /// JSON states how well the coefficient is known.
  double tolerated_sd = 0.0;
};

/// The uncertain parameters of a ship, coefficient_law() each by itself. Throws InputError for a name that the ship
/// does not have. The last one is no coefficient: kTiming.
std::vector<UncertainParameter> uncertain_parameters(const Ship& ship);

/// kTiming: without it, actuators sampled once a second look like late ones.
UncertainParameter timing_parameter();

/// Multiplies the parameters of a model by exp(theta), in the order of uncertain_parameters(); the timing is left
/// alone.
template <typename T, typename Theta>
void apply_uncertainty(Model<T>& model, const Theta& theta) {
  using std::exp;
  std::vector<T> factors(model.coefficients().size());
  for (std::size_t i = 0; i < factors.size(); ++i) factors[i] = T(exp(theta[static_cast<Eigen::Index>(i)]));
  model.multiply_coefficients(factors);
}

}  // namespace leeway::gap
