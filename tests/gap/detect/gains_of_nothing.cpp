#include "gap/detect/gains_of_nothing.hpp"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "core/distributions.hpp"

using namespace leeway;

namespace {

// Gains of one candidate with one column of this information: (ratio chi^2(1) - ln(1 + F))/2.
double chance_of_one(double information, double gain) {
  const double ratio = information / (1.0 + information);
  return chi_squared_survival(std::max(0.0, (2.0 * gain + std::log1p(information)) / ratio), 1.0);
}

gap::Projected projected(const Eigen::MatrixXd& F) { return {Eigen::VectorXd::Zero(F.rows()), F, {}}; }

}  // namespace

TEST_CASE("gains of nothing: a single column gains as its information says", "[gap]") {
  constexpr double information = 30.0;
  const std::vector<double> drawn = gap::gains_of_nothing(projected(Eigen::MatrixXd::Constant(1, 1, information)),
                                                          {{0, Eigen::VectorXd::Zero(1), std::nullopt}}, 4000, 1);
  REQUIRE(drawn.size() == 4000);
  CHECK(std::ranges::is_sorted(drawn));
  for (const double gain : {-1.0, 0.0, 1.0}) {
    const double expected = chance_of_one(information, gain);
    CAPTURE(gain, expected);
    CHECK(std::abs(gap::chance_of_gain(drawn, gain) - expected) < 4.0 * std::sqrt(expected / 4000.0));
  }
  // Beyond the draws e times less for each nat.
  CHECK(gap::chance_of_gain(drawn, drawn.back() + 3.0) ==
        Approx(gap::chance_of_gain(drawn, drawn.back() + 2.0) / std::exp(1.0)));
}

TEST_CASE("gains of nothing: independent candidates are so many chances, and one that is asked twice is one", "[gap]") {
  const Eigen::MatrixXd F = 30.0 * Eigen::MatrixXd::Identity(10, 10);
  std::vector<gap::LinearCandidate> ten, twice;
  for (Eigen::Index i = 0; i < 10; ++i) ten.push_back({i, Eigen::VectorXd::Zero(1), std::nullopt});
  for (int i = 0; i < 2; ++i) twice.push_back(ten.front());
  const double one = chance_of_one(30.0, 0.5);
  CHECK(gap::chance_of_gain(gap::gains_of_nothing(projected(F), ten, 4000, 2), 0.5) ==
        Approx(1.0 - std::pow(1.0 - one, 10.0)).epsilon(0.12));
  CHECK(gap::gains_of_nothing(projected(F), twice, 100, 3) ==
        gap::gains_of_nothing(projected(F), {ten.front()}, 100, 3));
  // In the mean over what nothing missing draws a Bayes factor is 1 (little information: its variance is finite).
  double mean = 0.0;
  for (const double gain : gap::gains_of_nothing(projected(0.01 * F), {ten.front()}, 4000, 4))
    mean += std::exp(gain) / 4000.0;
  CHECK(mean == Approx(1.0).epsilon(0.05));
  CHECK(gap::gains_of_nothing(projected(F), {}, 100, 5).empty());
}

TEST_CASE("gains of nothing: a start that does what is drawn away gains nothing by itself", "[gap]") {
  // A candidate that may only do one thing of size 1, with its neutral place out of reach: ln odds are b - F/2.
  Eigen::MatrixXd F = Eigen::MatrixXd::Zero(2, 2);
  F(1, 1) = 4.0;
  const std::vector<double> drawn =
      gap::gains_of_nothing(projected(F), {{0, Eigen::VectorXd::Zero(1), Eigen::Index{1}}}, 4000, 6);
  double sum = 0.0;
  for (const double gain : drawn) sum += gain;
  CHECK(sum / 4000.0 == Approx(-2.0).margin(0.15));  // N(-F/2, F)
}

TEST_CASE("scores: a root keeps small columns beside ones that are far larger", "[gap]") {
  // Two small columns that go together, beside a large one.
  Eigen::MatrixXd F(3, 3);
  F << 1e18, 3e8, -2e8, 3e8, 1.0, 0.8, -2e8, 0.8, 1.0;
  const Eigen::MatrixXd root = gap::root_of_scores(F), again = root * root.transpose();
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j)
      CHECK(again(i, j) == Approx(F(i, j)).margin(1e-9 * std::sqrt(F(i, i) * F(j, j))));
  // A column without information has no score.
  F.row(1).setZero();
  F.col(1).setZero();
  CHECK(gap::root_of_scores(F).row(1).norm() == 0.0);
}
