#include "gap/correct/seen_faults.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "core/random.hpp"
#include "core/units.hpp"
#include "dynamics/maneuvers.hpp"
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

gap::Fault corrected_for(const char* name, const std::vector<gap::Estimate>& numbers,
                         const std::vector<double>& left_open) {
  gap::Fault fault;
  fault.name = name;
  fault.parameters = numbers;
  fault.left_open = left_open;
  return fault;
}

bool is_identified(const gap::SeenFaults& seen, double rate) {
  const gap::SeenFault& one = likeliest(seen.faults);
  const double chance = gap::chance_of_gain(seen.gains_of_nothing, one.log_bayes_factor);
  return gap::is_identified({one.log_bayes_factor, 0.0, chance, one.fault.heldout_gain, one.fault.heldout_gain_sd},
                            rate);
}

// Holds a course by a yaw rate as it is read, once a second; rows of a second.
class Helmsman final : public Maneuver {
 public:
  Helmsman(double gain_s, double noise_sd, std::uint64_t seed)
      : gain_s_(gain_s), noise_sd_(noise_sd), random_(seed, "helmsman") {}

  void order(double t_s, const ShipState<double>& state, Actuators<double>& command) override {
    while (static_cast<double>(noise_.size()) < t_s + 1.0 - 1e-6) noise_.push_back(noise_sd_ * random_.normal());
    if (std::abs(t_s - std::round(t_s)) > 1e-6) return;
    const double read = state.nu(2) + noise_.back();
    command[Channel::delta] = std::clamp(-state.eta(2) - gain_s_ * read, -0.44, 0.44);
  }
  double noise(std::size_t second) const { return noise_.at(std::min(second, noise_.size() - 1)); }

 private:
  double gain_s_, noise_sd_;
  RandomStream random_;
  std::vector<double> noise_;  // by second [rad/s]
};

}  // namespace

TEST_CASE("sensors: a helm that answers the noise of the yaw rate does not make it late", "[gap]") {
  const Ship ship = read_ship("kvlcc2-l7");
  std::vector<Trajectory> recordings;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Helmsman helmsman(7.6, 0.06 * kDegree, seed);
    const Trajectory truth = simulate(SimulatedShip(ship), helmsman, {}, {0.1, 1.0, 360.0});
    Trajectory recording = observed(truth, test::usual_noise(1.0), RandomStream(seed, "helmsman noise"));
    recording.name = recording.file = "held" + std::to_string(seed);
    for (std::size_t k = 0; k < truth.size(); ++k) recording[Channel::r][k] = truth[Channel::r][k] + helmsman.noise(k);
    recordings.push_back(std::move(recording));
  }
  const gap::Campaign campaign = gap::prepare(ship, recordings, {});
  const gap::SeenFaults seen = gap::seen_faults(campaign, gap::fit_null(campaign, {.jobs = 2}), 2, 1);
  CAPTURE(likeliest(seen.faults).fault.name, likeliest(seen.faults).log_bayes_factor);
  CHECK_FALSE(is_identified(seen, 0.01));
}

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

TEST_CASE("sensors: what a correction left of a fault is found beside the coefficients", "[gap]") {
  const Ship ship = read_ship("esso-osaka-3m");
  const test::SimulatedCampaign of{.ship = "esso-osaka-3m", .recordings = 3, .duration_s = 200.0, .wind_mps = 0.0};
  const gap::FitOptions options{.jobs = 2};
  // Corrected for 2 deg of 3, and for an arm of which nothing is left.
  const gap::Campaign corrected = gap::prepare(ship, test::recorded(of, ship, {.heading_bias = 1.0 * kDegree}), {});
  const gap::FittedNull before = gap::fit_null(corrected, options);
  const gap::Fault heading = corrected_for("heading-bias", {{"heading_bias_deg", 2.0, 0.5}}, {1.0}),
                   lever = corrected_for("lever-arm", {{"lever_x_m", 0.3, 0.05}, {"lever_y_m", 0.0, 0.05}}, {0.1, 0.1}),
                   as_stated = corrected_for("log-scale", {{"log_scale", 0.05, 0.01}}, {});
  const gap::Campaign campaign = gap::with_free_faults(corrected, before, {heading, as_stated, lever});
  REQUIRE(campaign.free_faults.size() == 3);
  const gap::FittedNull fit = gap::fit_null(campaign, options, &before);
  CHECK(fit.faults == 3);
  CHECK(fit.coefficients() == before.coefficients());
  CHECK(fit.report.parameters.size() == before.report.parameters.size());
  const Eigen::VectorXd moved = fit.theta.segment(fit.coefficients(), 3);
  const Eigen::VectorXd sd = gap::posterior_covariance(fit).diagonal().segment(fit.coefficients(), 3).cwiseSqrt();
  CHECK(std::abs(moved[0] - 1.0) < 4.0 * sd[0]);
  CHECK(moved[0] > 4.0 * sd[0]);
  CHECK(std::abs(moved[1]) < 4.0 * sd[1]);
  CHECK(std::abs(moved[2]) < 4.0 * sd[2]);
  // As likely as recordings that have no fault, but for what three numbers cost.
  const gap::Campaign sound = gap::prepare(ship, test::recorded(of, ship, {}), {});
  const double without = gap::log_evidence(gap::fit_null(sound, options));
  CHECK(gap::log_evidence(fit) > without - 15.0);
  CHECK(gap::log_evidence(fit) > gap::log_evidence(before));
  // Nor are numbers freed where the points of time are others.
  gap::Campaign other = corrected;
  other.stretches.front().t_s.front() -= 0.5;
  CHECK(gap::with_free_faults(other, before, {heading}).free_faults.empty());
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
