#include "gap/detect/whiteness.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/distributions.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

Whiteness whiteness(const FittedNull& fit) {
  constexpr std::size_t kLags = kPolicy.detect.lags;
  Whiteness result;
  double statistic = 0.0, dof = 0.0;
  for (int i = 0; i < kShipStates; ++i) {
    double square = 0.0, n = 0.0;
    std::array<double, kLags + 1> products{};
    for (const Smoothed& smoothed : fit.smoothed) {
      const std::vector<Vec6>& z = smoothed.innovations;
      // The first points determine the initial state.
      for (std::size_t k = kPolicy.filter.first_points; k < z.size(); ++k) {
        if (std::isnan(z[k][i])) continue;
        square += z[k][i] * z[k][i];
        n += 1.0;
        for (std::size_t lag = 1; lag <= kLags && k >= lag + kPolicy.filter.first_points; ++lag)
          if (!std::isnan(z[k - lag][i])) products[lag] += z[k][i] * z[k - lag][i];
      }
    }
    if (n < kPolicy.detect.least_innovations) continue;
    for (std::size_t lag = 1; lag <= kLags; ++lag) {
      const double rho = products[lag] / square;
      statistic += n * (n + 2.0) / (n - static_cast<double>(lag)) * rho * rho;
      result.largest = std::max(result.largest, std::abs(rho));
    }
    dof += kLags;
  }
  if (dof > kReceiverLevel) result.p_value = chi_squared_survival(statistic, dof - kReceiverLevel);
  return result;
}

}  // namespace leeway::gap
