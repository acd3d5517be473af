#pragma once

#include <array>
#include <cstddef>

namespace leeway {

/// Below this square of the speed [m^2/s^2] a ship counts as at rest: v', r' and the drift angle are undefined there,
/// and forces that grow with the square of the speed are below 1e-9 N for the shipped ships.
inline constexpr double kAtRest_m2ps2 = 1e-12;

/// x within [low, high]; a limited autodiff scalar has no derivative left. T: double or an autodiff scalar.
template <typename T>
T limited(const T& x, double low, double high) {
  return x < T(low) ? T(low) : x > T(high) ? T(high) : x;
}

/// c0 + c1 x + c2 x^2.
template <typename T>
T quadratic(const std::array<T, 3>& c, const T& x) {
  return c[0] + (c[1] + c[2] * x) * x;
}

template <typename U, typename T, std::size_t n>
std::array<U, n> cast_all(const std::array<T, n>& from) {
  std::array<U, n> to{};
  for (std::size_t i = 0; i < n; ++i) to[i] = U(from[i]);
  return to;
}

}  // namespace leeway
