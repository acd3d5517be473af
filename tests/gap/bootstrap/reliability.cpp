#include "gap/bootstrap/reliability.hpp"

#include <cmath>
#include <numeric>

#include <catch2/catch.hpp>

#include "core/random.hpp"

using namespace leeway;

namespace {

// Answers that state `stated` of the first of two, which is the truth in a share of them.
gap::Bootstrap answers(std::size_t count, double stated, double right, std::size_t not_fitted = 0) {
  gap::Bootstrap result;
  for (std::size_t i = 0; i < count; ++i) {
    gap::SimulatedAnswer one;
    one.stated = {stated, 1.0 - stated};
    one.truth_is_first = static_cast<double>(i) < right * static_cast<double>(count);
    one.stated_of_first = stated;
    one.stated_of_truth = one.truth_is_first ? stated : 1.0 - stated;
    result.campaigns.push_back(one);
  }
  for (std::size_t i = 0; i < not_fitted; ++i) result.campaigns[i].stated_of_truth = 0.0;
  return result;
}

}  // namespace

TEST_CASE("reliability: what is stated too certainly is blunted to how often it is right", "[gap][bootstrap]") {
  gap::Bootstrap bootstrap = answers(2000, 0.95, 0.7);
  gap::fit_reliability(bootstrap);
  CHECK(bootstrap.sharpness == Approx(std::log(0.7 / 0.3) / std::log(0.95 / 0.05)).epsilon(0.02));
  const std::vector<double> p = gap::as_realized(bootstrap, {0.95, 0.05});
  CHECK(p[0] == Approx(0.7).margin(0.01));
  CHECK(p[0] + p[1] == Approx(1.0 - bootstrap.not_fitted));
}

TEST_CASE("reliability: what is stated too cautiously is sharpened, what is true stays", "[gap][bootstrap]") {
  gap::Bootstrap cautious = answers(2000, 0.6, 0.8), honest = answers(2000, 0.8, 0.8);
  gap::fit_reliability(cautious);
  gap::fit_reliability(honest);
  CHECK(gap::as_realized(cautious, {0.6, 0.4})[0] == Approx(0.8).margin(0.01));
  CHECK(honest.sharpness == Approx(1.0).margin(0.03));
}

TEST_CASE("reliability: few campaigns change little, none nothing but for what may not be fitted", "[gap][bootstrap]") {
  gap::Bootstrap few = answers(2, 0.9, 0.5), none;
  gap::fit_reliability(few);
  gap::fit_reliability(none);
  CHECK(few.sharpness < 1.0);
  CHECK(few.sharpness > 0.5);
  CHECK(none.sharpness == Approx(1.0).margin(1e-3));
  CHECK(none.not_fitted == Approx(0.5));  // Jeffreys' estimate of what nobody tried
}

TEST_CASE("reliability: the share of truths that were not fitted is taken from all alike", "[gap][bootstrap]") {
  gap::Bootstrap bootstrap = answers(39, 0.8, 0.8, 4);
  gap::fit_reliability(bootstrap);
  CHECK(bootstrap.not_fitted == Approx(4.5 / 40.0));
  // What was stated to be none of those fitted keeps its share.
  const std::vector<double> p = gap::as_realized(bootstrap, {0.5, 0.2});
  CHECK(p[0] + p[1] == Approx(0.7 * (1.0 - bootstrap.not_fitted)));
  CHECK(p[0] / p[1] == Approx(std::pow(2.5, bootstrap.sharpness)));
  CHECK(gap::as_realized(bootstrap, {0.0, 0.0}) == std::vector<double>{0.0, 0.0});
}

TEST_CASE("reliability: statements of many sizes are mapped by one power", "[gap][bootstrap]") {
  // Truths are drawn from probabilities p; p^2/sum p^2 is stated: a power of one half makes them true again.
  gap::Bootstrap bootstrap;
  RandomStream random(1, "reliability");
  for (int c = 0; c < 4000; ++c) {
    std::vector<double> p(4);
    for (double& x : p) x = std::exp(2.0 * random.normal());
    const double sum = std::accumulate(p.begin(), p.end(), 0.0);
    double left = sum * random.uniform();
    std::size_t truth = 0;
    while (truth + 1 < p.size() && (left -= p[truth]) >= 0.0) ++truth;
    gap::SimulatedAnswer one;
    double squares = 0.0;
    for (const double x : p) squares += x * x;
    for (const double x : p) one.stated.push_back(x * x / squares);
    one.stated_of_truth = one.stated[truth];
    bootstrap.campaigns.push_back(one);
  }
  gap::fit_reliability(bootstrap);
  CHECK(bootstrap.sharpness == Approx(0.5).margin(0.02));
}
