#include "dynamics/wind_process.hpp"

#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "core/wind.hpp"
#include "dynamics/maneuvers.hpp"

using namespace leeway;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

TEST_CASE("stochastic wind: the coefficients are those of the public code of the process", "[dynamics][wind]") {
  // Computed once from the published constants; each to the digits that stand here.
  struct Row {
    double mean, alpha, sigma, sd, alpha_direction;
  };
  for (const Row& row : {Row{1.0, 0.05353, 0.03295, 0.1007, 0.002583}, Row{2.0, 0.09541, 0.08304, 0.1901, 0.007306},
                         Row{10.0, 0.36628, 0.71288, 0.8329, 0.081682}}) {
    CAPTURE(row.mean);
    const WindSpeedProcess speed = wind_speed_process(row.mean);
    CHECK_THAT(speed.alpha, WithinAbs(row.alpha, 0.5e-5));
    CHECK_THAT(speed.sigma, WithinAbs(row.sigma, 0.5e-5));
    CHECK_THAT(speed.sigma / std::sqrt(2.0 * speed.alpha), WithinAbs(row.sd, 0.5e-4));
    CHECK_THAT(wind_direction_process(row.mean).alpha, WithinAbs(row.alpha_direction, 0.5e-6));
    CHECK_THAT(wind_direction_process(row.mean).sigma, WithinRel(2.3 * kDegree, 1e-14));
  }
}

TEST_CASE("stochastic wind: over a long run it has the mean and the spread of its processes", "[dynamics][wind]") {
  const double mean = 10.0, direction = 2.0, dt_s = 0.1;
  const int n = 400'000;
  WindProcess wind = WindProcess::stochastic(mean, direction, {5, "long run"});
  double sum = 0.0, squares = 0.0, c = 0.0, s = 0.0, lagged = 0.0, last = 0.0;
  for (int i = 0; i < n; ++i) {
    const double U = wind.value().norm(), gamma = std::atan2(wind.value()(1), wind.value()(0)) - direction;
    sum += U;
    squares += (U - mean) * (U - mean);
    if (i > 0) lagged += (U - mean) * last;
    last = U - mean;
    c += std::cos(gamma);
    s += std::sin(gamma);
    wind.advance(dt_s);
  }
  const WindSpeedProcess p = wind_speed_process(mean);
  // Euler-Maruyama is x' = (1 - a) x + sigma sqrt(dt) z with a = alpha dt: variance sigma^2 dt / (2 a - a^2).
  const double a = p.alpha * dt_s, variance = p.sigma * p.sigma * dt_s / (2.0 * a - a * a);
  // Samples are correlated over 1/alpha: n alpha dt / 2 independent ones for the mean, twice that for the variance.
  const double independent = n * a / 2.0;
  CHECK_THAT(sum / n, WithinAbs(mean, 4.0 * std::sqrt(variance / independent)));
  CHECK_THAT(squares / n, WithinRel(variance, 4.0 * std::sqrt(2.0 / (2.0 * independent))));
  CHECK_THAT(lagged / squares, WithinAbs(1.0 - a, 4.0 * std::sqrt(2.0 * a / n)));
  // The stationary density of the direction is exp(kappa cos gamma).
  const WindDirectionProcess d = wind_direction_process(mean);
  const double kappa = 2.0 * d.alpha / (d.sigma * d.sigma);
  const double resultant = std::cyl_bessel_i(1.0, kappa) / std::cyl_bessel_i(0.0, kappa);
  const double turns = n * d.alpha * dt_s / 2.0;
  CHECK_THAT(c / n, WithinAbs(resultant, 4.0 * (1.0 - resultant) * std::sqrt(1.0 / turns) + 1e-4));
  CHECK_THAT(s / n, WithinAbs(0.0, 4.0 / std::sqrt(kappa * turns)));
}

TEST_CASE("stochastic wind: it starts in its stationary distribution", "[dynamics][wind]") {
  const double direction = -0.7;
  for (const double mean : {1.0, 3.0}) {
    CAPTURE(mean);
    const int n = 20'000;
    double sum = 0.0, squares = 0.0, c = 0.0, c2 = 0.0, s = 0.0;
    for (int i = 0; i < n; ++i) {
      const Vec2<double> w =
          WindProcess::stochastic(mean, direction, {1, "start", static_cast<std::uint64_t>(i)}).value();
      const double gamma = std::atan2(w(1), w(0)) - direction;
      sum += w.norm();
      squares += (w.norm() - mean) * (w.norm() - mean);
      c += std::cos(gamma);
      c2 += std::cos(gamma) * std::cos(gamma);
      s += std::sin(gamma);
    }
    const WindSpeedProcess p = wind_speed_process(mean);
    const double variance = p.sigma * p.sigma / (2.0 * p.alpha);
    CHECK_THAT(sum / n, WithinAbs(mean, 4.0 * std::sqrt(variance / n)));
    CHECK_THAT(squares / n, WithinRel(variance, 4.0 * std::sqrt(2.0 / n)));
    const double kappa = std::pow(mean, 1.5) / std::pow(32.0 * kDegree, 2);
    const double resultant = std::cyl_bessel_i(1.0, kappa) / std::cyl_bessel_i(0.0, kappa);
    const double spread = c2 / n - (c / n) * (c / n);
    CHECK_THAT(c / n, WithinAbs(resultant, 4.0 * std::sqrt(spread / n)));
    CHECK_THAT(s / n, WithinAbs(0.0, 4.0 / std::sqrt(n * kappa)));
  }
}

TEST_CASE("stochastic wind: the speed never becomes negative, the same stream gives the same wind",
          "[dynamics][wind]") {
  // At the longest allowed step the scheme scatters most.
  const double mean = 0.02, dt_s = longest_wind_step_s(mean);
  WindProcess a = WindProcess::stochastic(mean, 1.0, {3, "wind"});
  WindProcess b = WindProcess::stochastic(mean, 1.0, {3, "wind"});
  WindProcess other = WindProcess::stochastic(mean, 1.0, {4, "wind"});
  CHECK(a.is_stochastic());
  for (int i = 0; i < 1000; ++i) {
    a.advance(dt_s);
    b.advance(dt_s);
    other.advance(dt_s);
    CHECK(a.value() == b.value());
    CHECK(a.value() != other.value());
    CHECK(a.value().allFinite());
  }
  CHECK_THROWS_AS(a.advance(1.001 * dt_s), UsageError);
}

TEST_CASE("steady wind: it is its vector, and a mean of zero is calm", "[dynamics][wind]") {
  WindProcess wind = WindProcess::steady(1.3, 0.4);
  const Vec2<double> start = wind.value();
  wind.advance(1e6);
  CHECK(wind.value() == start);
  CHECK(start == wind_from_vector(1.3, 0.4));
  CHECK_FALSE(wind.is_stochastic());
  CHECK(WindProcess().value() == Vec2<double>::Zero());
  WindProcess calm = WindProcess::stochastic(0.0, 0.4, {1, "wind"});
  calm.advance(1e6);
  CHECK(calm.value() == Vec2<double>::Zero());
  CHECK(WindProcess::stochastic(1e-5, 0.4, {1, "wind"}).value().allFinite());
}

TEST_CASE("simulation: stochastic wind acts on the ship and is recorded as it acted", "[dynamics][wind]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const WindProcess wind = WindProcess::stochastic(2.0, 1.0, {7, "wind"});
  const auto maneuver = turning(ship, 0.3);
  const Trajectory t = simulate(SimulatedShip(ship), *maneuver, wind, {0.1, 0.1, 20.0});
  WindProcess again = wind;
  SimulatedShip by_hand(ship);
  Actuators<double> command = by_hand.actuators;
  command[Channel::delta] = 0.3;
  for (std::size_t k = 0; k < t.size(); ++k) {
    CHECK(t[Channel::wind_speed][k] == again.value().norm());
    CHECK(t[Channel::u][k] == by_hand.state.nu(0));
    CHECK(t[Channel::r][k] == by_hand.state.nu(2));
    by_hand.step(command, again.value(), 0.1);
    again.advance(0.1);
  }
}
