#pragma once

#include <cstddef>

#include "gap/policy/policy.hpp"
#include "gap/result/ship_file.hpp"

/// What is said of the ship's file: pure functions of what fits found. docs/gap-explain.md says what they mean.
namespace leeway::gap {

/// Whether a module is off: the coefficients of it alone predict what was left out better, more than one of so many
/// modules would by chance where nothing is off (Markov's inequality), and free runs follow better beyond chance.
///   modules  how many were tried
bool is_off(const CalibratedModule& module, std::size_t modules, double false_alarm);

/// Whether a coefficient is likelier off by far more than the file states than not; of one that has no such probability
/// (an absolute uncertainty, another form of a force), whether its interval lies beyond the stated standard deviations
/// in which the file is taken at its word.
bool is_off(const FittedCoefficient& coefficient, const Policy& policy = kPolicy);

struct ShipFileFound {
  bool is_off = false;        ///< a module, a coefficient, or all coefficients together
  bool converged = true;      ///< the fit
  bool keeps_course = false;  ///< all the time: how hull and rudders answer does not show
  bool is_spoiled = false;    ///< sensors or readings that are at fault were not corrected
  std::size_t samples = 0;    ///< scalar measurements
  double determined = 0.0;    ///< how many of the coefficients the recordings know better than the file states
};
ShipFileState decide_ship_file(const ShipFileFound& found, const Policy& policy = kPolicy);

}  // namespace leeway::gap
