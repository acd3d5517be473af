#include "core/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace leeway {

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double quantile(std::span<const double> sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

double robust_sd(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return 1.4826 * median(std::move(values));
}

}  // namespace leeway
