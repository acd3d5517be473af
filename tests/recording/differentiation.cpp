#include "recording/differentiation.hpp"

#include <cmath>

#include <catch2/catch.hpp>

#include "recording/trajectory.hpp"

using namespace leeway;

TEST_CASE("derivative: a cubic is differentiated exactly, at any spacing and at the ends", "[recording]") {
  std::vector<double> t, y;
  for (int i = 0; i < 30; ++i) {
    t.push_back(0.7 * i + 0.08 * std::sin(3.0 * i));
    y.push_back(2.0 - 0.3 * t.back() + 0.05 * std::pow(t.back(), 2) - 0.001 * std::pow(t.back(), 3));
  }
  for (const double window_s : {0.0, 5.0}) {
    const std::vector<double> d = derivative(t, y, window_s);
    for (std::size_t i = 0; i < t.size(); ++i)
      CHECK(d[i] == Approx(-0.3 + 0.1 * t[i] - 0.003 * t[i] * t[i]).margin(1e-9));
  }
}

TEST_CASE("derivative: nothing is differentiated across a hole, and a missing sample stays missing", "[recording]") {
  std::vector<double> t, y;
  for (int i = 0; i < 20; ++i) {
    t.push_back(i + (i >= 10 ? 30.0 : 0.0));
    y.push_back(i >= 10 ? 500.0 - 2.0 * i : 3.0 * i);  // another level and slope behind the hole
  }
  y[4] = kMissing;
  const std::vector<double> d = derivative(t, y);
  CHECK(std::isnan(d[4]));
  for (std::size_t i = 5; i < 10; ++i) CHECK(d[i] == Approx(3.0));
  for (std::size_t i = 10; i < 20; ++i) CHECK(d[i] == Approx(-2.0));
  CHECK(std::isnan(derivative(std::vector{1.0}, std::vector{1.0})[0]));
}
