#pragma once

#include <string>
#include <vector>

#include "estimate/coefficient_estimates.hpp"

namespace leeway::estimate {

/// A hull whose captive tests are public: what was measured beside what is estimated from its particulars.
struct MeasuredHull {
  struct Value {
    std::string name;
    double measured, estimated;
  };
  std::string name, description, source;
  CompleteHull hull;
  std::vector<Value> values;  ///< coefficients, and kTacticalDiameter where it is published
};

/// Of a turn with 35 deg of rudder, by L_pp, the geometric mean of both sides: no coefficient, but what the estimate as
/// a whole is judged by.
inline constexpr std::string_view kTacticalDiameter = "turning.tactical_diameter";

/// The hulls of configs/hulls, sorted by name. Derivatives that were measured with the rudder amidships are compared
/// without the rudder's share, which the estimate itself gives (`with_rudder` in their files).
std::vector<MeasuredHull> measured_hulls();
/// One of them, from a file.
MeasuredHull read_measured_hull(const std::string& path);

/// How a coefficient's error is counted.
struct ErrorKind {
  std::string_view name;
  bool is_absolute;  ///< as a difference, since its sign is not certain; else as the logarithm of the ratio
  double prior_sd;   ///< before any hull was looked at
};
const std::vector<ErrorKind>& error_kinds();
const ErrorKind* find_error_kind(std::string_view name);

/// measured - estimated, or the logarithm of their ratio.
double error_of(const ErrorKind& kind, const MeasuredHull::Value& value);

/// Standard deviations of the estimates' errors.
struct Width {
  std::string name;
  double sd;  ///< a normal law with it has the 95 % interval of Student's t, which few hulls ask for
  int hulls;  ///< that it was fitted to
};
/// Of each kind from the prior, which counts as kPriorHulls hulls, and the hulls' errors.
///   without  names of hulls that are left out
std::vector<Width> fit_widths(const std::vector<MeasuredHull>& hulls, const std::vector<std::string>& without = {});
inline constexpr double kPriorHulls = 8.0;

/// How well an estimate is known.
struct Spread {
  double sd;
  bool is_absolute;  ///< of the value; else of its logarithm
};
/// The width of its kind, and at least what its methods differ by. Where they differ in sign, that of a value, whatever
/// the kind: its sign is not known.
Spread uncertainty_of(const CoefficientEstimate& estimate, const ErrorKind& kind, const std::vector<Width>& widths);

}  // namespace leeway::estimate
