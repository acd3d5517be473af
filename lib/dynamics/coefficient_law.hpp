#pragma once

#include <string>
#include <vector>

#include "core/random.hpp"
#include "dynamics/model.hpp"

namespace leeway {

/// How much later the actuators moved than the recording's samples, joined by lines, say; 1 is a tenth of the sampling
/// time. A ship's file may state it among its uncertainties, but it is no coefficient of the ship.
inline constexpr const char* kTiming = "actuators.timing";

/// How far a coefficient may lie from where the ship's file has it: by a factor exp(theta), theta normal with mean 0.
struct UncertainCoefficient {
  std::string name;  ///< as in coefficient_factors
  double log_sd = 0.0;
  bool is_stated = false;  ///< by the ship's file; else the default of its module
};

/// What a ship's file says of how well its coefficients are known, read here by all tools: the file's `uncertainty`,
/// the defaults of the force modules where it says nothing, and its `coefficient_covariance` in place of both.
struct CoefficientLaw {
  std::vector<UncertainCoefficient> coefficients;  ///< in the order of Model::coefficients()
  Eigen::MatrixXd covariance;                      ///< of theta, coefficients.size() square
};

/// Throws InputError for a name that the ship does not have.
CoefficientLaw coefficient_law(const Ship& ship);

/// Factors exp(spread theta) drawn from the law.
std::vector<CoefficientFactor> draw_factors(const CoefficientLaw& law, double spread, RandomStream& random);

}  // namespace leeway
