#include "recording/differentiation.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra.hpp"
#include "core/statistics.hpp"
#include "recording/trajectory.hpp"

namespace leeway {
namespace {

constexpr std::size_t kNeighbors = 2;         // on each side
constexpr double kLongestStep = 1.5;          // usual steps, as of the grids
constexpr std::size_t kMostSamples = 10'000;  // of a window: more would only cost time

// Slope at 0 of the least-squares polynomial, of degree 3 at most, through times around 0.
double slope_at_zero(std::span<const double> times, std::span<const double> values) {
  const auto n = static_cast<Eigen::Index>(times.size());
  const Eigen::Index terms = std::min<Eigen::Index>(4, n);
  double span = 0.0;
  for (const double t : times) span = std::max(span, std::abs(t));
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double x = times[i] / span;
    const Eigen::Vector4d powers(1.0, x, x * x, x * x * x);
    normal += powers * powers.transpose();
    right += powers * values[i];
  }
  const Eigen::VectorXd fit = normal.topLeftCorner(terms, terms).ldlt().solve(right.head(terms));
  return fit(1) / span;
}

}  // namespace

std::vector<double> derivative(std::span<const double> t, std::span<const double> values, double window_s) {
  std::vector<double> at, y;
  std::vector<std::size_t> row;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    at.push_back(t[i]);
    y.push_back(values[i]);
    row.push_back(i);
  }
  std::vector<double> result(values.size(), kMissing), steps, times, shifted;
  for (std::size_t k = 1; k < at.size(); ++k) steps.push_back(at[k] - at[k - 1]);
  const double longest = kLongestStep * median(steps);
  const auto is_apart = [&](std::size_t k) { return at[k] - at[k - 1] > longest; };
  for (std::size_t k = 0; k < at.size(); ++k) {
    const auto is_within = [&](std::size_t j, std::size_t count) {
      return window_s > 0.0 ? std::abs(at[j] - at[k]) <= 0.5 * window_s && count < kMostSamples : count <= kNeighbors;
    };
    std::size_t first = k, last = k;
    while (first > 0 && !is_apart(first) && is_within(first - 1, k - first + 1)) --first;
    while (last + 1 < at.size() && !is_apart(last + 1) && is_within(last + 1, last + 1 - k)) ++last;
    // At an end the window keeps its number of samples.
    const std::size_t wanted = 2 * kNeighbors + 1;
    while (last - first + 1 < wanted && first > 0 && !is_apart(first)) --first;
    while (last - first + 1 < wanted && last + 1 < at.size() && !is_apart(last + 1)) ++last;
    if (first == last) continue;
    times.clear();
    shifted.clear();
    for (std::size_t j = first; j <= last; ++j) {
      times.push_back(at[j] - at[k]);
      shifted.push_back(y[j] - y[k]);
    }
    result[row[k]] = slope_at_zero(times, shifted);
  }
  return result;
}

}  // namespace leeway
