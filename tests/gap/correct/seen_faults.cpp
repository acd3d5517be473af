#include "gap/correct/seen_faults.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <catch2/catch.hpp>

#include "gap/decide/sensors.hpp"
#include "gap/detect/gains_of_nothing.hpp"
#include "gap/fit/null_fit.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;

namespace {

struct Fitted {
  gap::Campaign campaign;
  gap::FittedNull fit;
};

Fitted fitted(const test::Injected& fault) {
  const Ship ship = read_ship("esso-osaka-3m");
  const test::SimulatedCampaign of{.ship = "esso-osaka-3m", .recordings = 3, .duration_s = 200.0, .wind_mps = 0.0};
  Fitted result;
  result.campaign = gap::prepare(ship, test::recorded(of, ship, fault), {});
  result.fit = gap::fit_null(result.campaign, {.jobs = 2});
  return result;
}

const gap::SeenFault& likeliest(const std::vector<gap::SeenFault>& seen) {
  return *std::ranges::max_element(seen, {}, &gap::SeenFault::log_bayes_factor);
}

bool is_identified(const gap::SeenFaults& seen, double rate) {
  const gap::SeenFault& one = likeliest(seen.faults);
  const double chance = gap::chance_of_gain(seen.gains_of_nothing, one.log_bayes_factor);
  return gap::is_identified({one.log_bayes_factor, 0.0, chance, one.fault.heldout_gain, one.fault.heldout_gain_sd},
                            rate);
}

}  // namespace

TEST_CASE("filter: the columns of sensors are derivatives by what they add to the measurements", "[gap]") {
  const Fitted sound = fitted({});
  const gap::LinearStretch& stretch = sound.fit.stretches.front();
  // A heading too high by 1, and a yaw rate too high by a share of itself.
  const auto added = [](const gap::Vec6& y, double bias, double scale) {
    gap::Vec6 result = gap::Vec6::Zero();
    result[2] = bias;
    result[5] = scale * y[5];
    return result;
  };
  const auto& measured = stretch.data->measured;
  const gap::MeasuredColumns columns{2, [&](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) {
                                       out.col(0) = added(measured[k], 1.0, 0.0);
                                       out.col(1) = added(measured[k], 0.0, 1.0);
                                     }};
  const gap::Evidence with = gap::evidence(stretch, sound.fit.noise, 0, nullptr, columns);
  const Eigen::Vector2d beta(0.003, 0.05);
  gap::Stretch corrected = *stretch.data;
  for (gap::Vec6& y : corrected.measured) y -= added(y, beta[0], beta[1]);
  gap::LinearStretch without = stretch;
  without.data = std::make_shared<const gap::Stretch>(corrected);
  const double expected =
      with.log_likelihood + with.b.tail<2>().dot(beta) - 0.5 * beta.dot(with.F.bottomRightCorner<2, 2>() * beta);
  CHECK(gap::evidence(without, sound.fit.noise).log_likelihood == Approx(expected).epsilon(1e-9));
}

TEST_CASE("sensors: the filter sees a planted fault at its size, and none where there is none", "[gap][long]") {
  const double rate = 0.01;
  {
    const Fitted sound = fitted({});
    const gap::SeenFaults seen = gap::seen_faults(sound.campaign, sound.fit, 2, 1);
    CAPTURE(likeliest(seen.faults).fault.name);
    CHECK_FALSE(is_identified(seen, rate));
  }
  struct Row {
    const char* name;
    test::Injected fault;
    double size;  // of its first number, in its unit
  };
  const Row rows[] = {{"rate-bias", {.rate_bias = 0.1 * kDegree}, 0.1},
                      {"heading-bias", {.heading_bias = 2.0 * kDegree}, 2.0},
                      {"log-scale", {.log_scale = 0.06}, 0.06},
                      {"heading-latency", {.heading_latency_s = 0.8}, 0.8},
                      {"rate-scale", {.rate_scale = 0.08}, 0.08}};
  for (const Row& row : rows) {
    CAPTURE(row.name);
    const Fitted faulty = fitted(row.fault);
    const gap::SeenFaults seen = gap::seen_faults(faulty.campaign, faulty.fit, 2, 1);
    const gap::SeenFault& best = likeliest(seen.faults);
    CHECK(best.fault.name == row.name);
    CHECK(is_identified(seen, rate));
    CHECK_FALSE(best.is_small);
    const gap::Estimate& number = best.fault.parameters.front();
    CHECK(std::abs(number.value - row.size) < 4.0 * number.sd + 0.05 * row.size);
  }
}
