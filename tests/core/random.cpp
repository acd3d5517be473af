#include "core/random.hpp"

#include <cmath>
#include <map>

#include <catch2/catch.hpp>

using namespace leeway;
using Catch::Matchers::WithinAbs;

TEST_CASE("random: the mean, variance and tails of normal() are those of a standard normal", "[core][random]") {
  RandomStream stream(7, "moments");
  const int n = 200'000;
  double sum = 0.0, squares = 0.0, fourth = 0.0;
  int beyond_two = 0;
  for (int i = 0; i < n; ++i) {
    const double x = stream.normal();
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
    if (std::abs(x) > 2.0) ++beyond_two;
  }
  // Five standard deviations of each estimate: 1/sqrt(n), sqrt(2/n), sqrt(96/n), sqrt(p(1-p)/n).
  CHECK_THAT(sum / n, WithinAbs(0.0, 5.0 / std::sqrt(n)));
  CHECK_THAT(squares / n, WithinAbs(1.0, 5.0 * std::sqrt(2.0 / n)));
  CHECK_THAT(fourth / n, WithinAbs(3.0, 5.0 * std::sqrt(96.0 / n)));
  const double p = std::erfc(2.0 / std::sqrt(2.0));
  CHECK_THAT(static_cast<double>(beyond_two) / n, WithinAbs(p, 5.0 * std::sqrt(p * (1.0 - p) / n)));
}

TEST_CASE("random: uniform numbers lie evenly from 0 to 1, and below(n) gives every number below n", "[core][random]") {
  RandomStream stream(3, "uniform");
  const int n = 100'000;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < n; ++i) {
    const double x = stream.uniform();
    REQUIRE((x >= 0.0 && x < 1.0));
    sum += x;
    squares += x * x;
  }
  CHECK_THAT(sum / n, WithinAbs(0.5, 5.0 * std::sqrt(1.0 / 12.0 / n)));
  CHECK_THAT(squares / n, WithinAbs(1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0 / n)));
  std::vector<int> count(7, 0);
  for (int i = 0; i < 70'000; ++i) ++count[stream.below(7)];
  for (const int c : count) CHECK_THAT(c, WithinAbs(10'000.0, 5.0 * std::sqrt(70'000.0 * 6.0 / 49.0)));
  CHECK(stream.below(1) == 0);
}

TEST_CASE("random: seed, purpose and index each select another stream, equal ones the same", "[core][random]") {
  const auto first = [](std::uint64_t seed, const char* purpose, std::uint64_t index) {
    RandomStream stream(seed, purpose, index);
    return std::vector<double>{stream.uniform(), stream.normal(), stream.normal(), stream.uniform()};
  };
  const auto reference = first(11, "noise", 2);
  CHECK(first(11, "noise", 2) == reference);
  CHECK(first(12, "noise", 2) != reference);
  CHECK(first(11, "noises", 2) != reference);
  CHECK(first(11, "noise", 3) != reference);
}

TEST_CASE("random: the first numbers of a stream stay what they are", "[core][random]") {
  // Golden values: a change of them changes every result of every seed and belongs into the changelog.
  RandomStream stream(1, "pinned", 4);
  CHECK(stream.uniform() == 0.35035242740756123);
  CHECK(stream.uniform(-2.0, 5.0) == 0.39335382793031881);
  // log() and sqrt() of other libraries may differ in the last bit.
  CHECK_THAT(stream.normal(), Catch::Matchers::WithinRel(-0.65898116691417075, 1e-14));
  CHECK_THAT(stream.normal(), Catch::Matchers::WithinRel(0.79972081898752267, 1e-14));
  CHECK(stream.below(1000) == 899);
}

TEST_CASE("random: a shuffle keeps all items and every order is equally likely", "[core][random]") {
  RandomStream stream(5, "shuffle");
  std::map<std::vector<int>, int> seen;
  for (int i = 0; i < 12'000; ++i) {
    std::vector<int> items{1, 2, 3};
    stream.shuffle(items);
    ++seen[items];
  }
  REQUIRE(seen.size() == 6);
  for (const auto& [order, count] : seen) {
    CHECK(order[0] + order[1] + order[2] == 6);
    CHECK_THAT(count, WithinAbs(2000.0, 5.0 * std::sqrt(12'000.0 * 5.0 / 36.0)));
  }
}
