#pragma once

#include <array>
#include <string>
#include <vector>

#include "estimate/statistics.hpp"

namespace leeway::estimate {

/// One formula's value of a coefficient.
struct MethodValue {
  const FormulaRange* formula;
  double value;
};

/// A coefficient by one formula, or the mean of several; names as in coefficient_factors.
struct CoefficientEstimate {
  std::string name;
  double value = 0.0;
  std::vector<MethodValue> methods;
  std::string remark;  ///< what else is to be said of where it comes from

  /// "mean of A [C_b 0.5 to 0.85] (-0.41); B [no published range known] (-0.39)".
  std::string source() const;
  /// Whether one formula's value is positive and another one's negative.
  bool differs_in_sign() const;
};

struct CoefficientEstimates {
  std::vector<CoefficientEstimate> all;
  std::array<double, 3> K_T{};        ///< constant, J, J^2
  std::vector<std::string> warnings;  ///< parameters outside the range of a formula, values that are limited

  /// The value of a name that is there.
  double operator[](std::string_view name) const;
  const CoefficientEstimate* find(std::string_view name) const;
};

/// Every coefficient of mass, hull, propeller and rudder that particulars tell something of. "hull.resistance" is R_0,
/// "propeller.K_T" the thrust coefficient at half the advance ratio at which it ends; "propeller.1-w_P" and the like
/// are the differences to 1.
CoefficientEstimates estimate_coefficients(const CompleteHull& hull);

}  // namespace leeway::estimate
