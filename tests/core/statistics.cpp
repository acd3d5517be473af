#include "core/statistics.hpp"

#include <vector>

#include <catch2/catch.hpp>

using namespace leeway;

TEST_CASE("statistics: the quantile of a share is a value that so many do not exceed", "[core]") {
  const std::vector<double> sorted{-3.0, -1.0, 0.5, 2.0, 7.0};
  CHECK(quantile(sorted, 0.0) == -3.0);
  CHECK(quantile(sorted, 0.3) == -1.0);
  CHECK(quantile(sorted, 0.5) == 0.5);
  CHECK(quantile(sorted, 0.99) == 2.0);
  CHECK(quantile(sorted, 1.0) == 7.0);
  CHECK(quantile(std::vector{4.5}, 0.7) == 4.5);
}
