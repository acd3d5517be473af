#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace leeway::gap {

/// The natural cubic spline through those samples of a channel that are there. Beyond its ends it holds the end value.
/// A channel is read with rising time: the caller keeps the place of the last reading.
class Spline {
 public:
  Spline() = default;
  /// Times increase strictly; samples that are NaN are passed over.
  Spline(std::span<const double> t, std::span<const double> x);

  bool empty() const { return t_.empty(); }
  double value(double t, std::size_t& place) const;
  /// The time between the samples around t, infinite beyond the ends.
  double gap(double t, std::size_t& place) const;

 private:
  /// Index of the interval that holds t.
  std::size_t find(double t, std::size_t place) const;
  std::vector<double> t_, x_, curvature_;
};

}  // namespace leeway::gap
