#pragma once

#include <array>

namespace leeway::estimate {

/// A propeller of the Wageningen B series.
struct SeriesPropeller {
  double blades = 4.0, area_ratio = 0.55, pitch_ratio = 0.8;
};

/// Thrust coefficient at a Reynolds number of 2e6, for 2 to 7 blades, A_E/A_0 0.3 to 1.05, P/D 0.5 to 1.4.
/// Source: Oosterveld & van Oossanen (1975), Int. Shipbuilding Progress 22 (251), 251-262: 39 terms
/// C J^s (P/D)^t (A_E/A_0)^u Z^v.
double wageningen_K_T(const SeriesPropeller& propeller, double J);

/// The advance ratio at which the thrust ends.
double wageningen_J_0(const SeriesPropeller& propeller);

/// The quadratic in J (constant, J, J^2) through the series by least squares, from J = 0 to where the thrust ends.
struct QuadraticThrust {
  std::array<double, 3> K_T;
  double largest_error;
};
QuadraticThrust fit_quadratic(const SeriesPropeller& propeller);

}  // namespace leeway::estimate
