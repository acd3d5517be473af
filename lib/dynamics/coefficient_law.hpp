#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/random.hpp"
#include "dynamics/model.hpp"

namespace leeway {

/// How much later the actuators moved than the recording's samples, joined by lines, say; 1 is a tenth of the sampling
/// time. A ship's file may state it among its uncertainties, but it is no coefficient of the ship.
inline constexpr const char* kTiming = "actuators.timing";

/// How far a coefficient may lie from where the ship's file has it, theta normal with mean 0: by a factor exp(theta),
/// or where its sign is not certain by the difference theta.
struct UncertainCoefficient {
  std::string name;                            ///< as in coefficient_factors
  double sd = 0.0;                             ///< of theta
  bool is_stated = false;                      ///< by the ship's file; else the default of its module
  bool is_absolute = false;                    ///< theta is a difference in the coefficient's own unit
  std::optional<double> value = std::nullopt;  ///< of the coefficient as the ship has it; nothing of a group
  bool is_form = false;                        ///< a term of another form of the same force
};

/// What theta does to it.
CoefficientFactor changed(const UncertainCoefficient& coefficient, double theta);

/// Correlation of the same coefficient of two sides, or of two devices that are built alike: one formula or measurement
/// gives both, so that most of its error is common (chosen here).
inline constexpr double kSidesCorrelation = 0.6;

/// What a ship's file says of how well its coefficients are known, read here by all tools: the file's `uncertainty`,
/// the defaults of the force modules where it says nothing, and its `coefficient_covariance` in place of both. Where
/// that says nothing of two sides (rudder.gain_port and _starboard, thruster.K_T_bow_positive and _negative, ...),
/// their errors have kSidesCorrelation.
struct CoefficientLaw {
  std::vector<UncertainCoefficient> coefficients;  ///< in the order of Model::coefficients()
  Eigen::MatrixXd covariance;                      ///< of theta, coefficients.size() square
};

/// Throws InputError for a name that the ship does not have.
CoefficientLaw coefficient_law(const Ship& ship);

/// Factors exp(spread theta), or differences spread theta, drawn from the law.
std::vector<CoefficientFactor> draw_factors(const CoefficientLaw& law, double spread, RandomStream& random);

}  // namespace leeway
