#include "gap/sensors/spline.hpp"

#include <cmath>
#include <limits>

namespace leeway::gap {

Spline::Spline(std::span<const double> t, std::span<const double> x) {
  for (std::size_t k = 0; k < t.size(); ++k)
    if (std::isfinite(x[k])) {
      t_.push_back(t[k]);
      x_.push_back(x[k]);
    }
  const std::size_t n = t_.size();
  curvature_.assign(n, 0.0);
  if (n < 3) return;
  // The second derivatives M solve h_k M_{k-1} + 2 (h_k + h_{k+1}) M_k + h_{k+1} M_{k+1} = 6 (slope change), M = 0 at
  // the ends: elimination, then substitution.
  std::vector<double> upper(n, 0.0);
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const double h0 = t_[k] - t_[k - 1], h1 = t_[k + 1] - t_[k];
    const double change = 6.0 * ((x_[k + 1] - x_[k]) / h1 - (x_[k] - x_[k - 1]) / h0);
    const double pivot = 2.0 * (h0 + h1) - h0 * upper[k - 1];
    upper[k] = h1 / pivot;
    curvature_[k] = (change - h0 * curvature_[k - 1]) / pivot;
  }
  for (std::size_t k = n - 2; k >= 1; --k) curvature_[k] -= upper[k] * curvature_[k + 1];
}

std::size_t Spline::find(double t, std::size_t place) const {
  const std::size_t last = t_.size() - 2;
  std::size_t k = place > last ? last : place;
  while (k > 0 && t < t_[k]) --k;
  while (k < last && t >= t_[k + 1]) ++k;
  return k;
}

double Spline::value(double t, std::size_t& place) const {
  if (t <= t_.front()) return x_.front();
  if (t >= t_.back()) return x_.back();
  const std::size_t k = place = find(t, place);
  const double h = t_[k + 1] - t_[k], b = (t - t_[k]) / h, a = 1.0 - b;
  return a * x_[k] + b * x_[k + 1] +
         h * h / 6.0 * ((a * a * a - a) * curvature_[k] + (b * b * b - b) * curvature_[k + 1]);
}

double Spline::gap(double t, std::size_t& place) const {
  if (t_.size() < 2 || t < t_.front() || t > t_.back()) return std::numeric_limits<double>::infinity();
  const std::size_t k = place = find(t, place);
  return t_[k + 1] - t_[k];
}

}  // namespace leeway::gap
