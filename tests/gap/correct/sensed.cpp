#include "gap/correct/sensed.hpp"

#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include <catch2/catch.hpp>

#include "core/units.hpp"
#include "gap/sensors/audit.hpp"
#include "gap/simulated_campaign.hpp"

using namespace leeway;

namespace {

gap::Fault of_seconds(const char* name, const char* of_velocities, const char* of_rate, double seconds) {
  gap::Fault result;
  result.name = name;
  result.parameters = {{of_velocities, seconds, 0.1}, {of_rate, seconds, 0.1}};
  return result;
}
gap::Fault late_by(double seconds) {
  return of_seconds("velocity-latency", "velocity_latency_s", "rate_latency_s", seconds);
}
gap::Fault filtered_by(double seconds) { return of_seconds("sensor-filter", "filter_s", "rate_filter_s", seconds); }

gap::Fault corrected_for(const char* name, const std::vector<gap::Estimate>& numbers,
                         const std::vector<double>& left_open) {
  gap::Fault fault;
  fault.name = name;
  fault.parameters = numbers;
  fault.left_open = left_open;
  return fault;
}

// Recordings with a fault planted, as corrected for `faults` and as sound sensors would have measured them.
struct Sounded {
  gap::Campaign corrected, sound;
  gap::FittedNull before, after;
};

Sounded sounded(const test::Injected& planted, const std::vector<gap::Fault>& faults) {
  const Ship ship = read_ship("esso-osaka-3m");
  const gap::FroudeScale scale(ship.particulars.L_pp);
  const test::SimulatedCampaign of{.ship = "esso-osaka-3m", .recordings = 3, .duration_s = 200.0, .wind_mps = 0.0};
  const std::vector<Trajectory> recorded = test::recorded(of, ship, planted);
  std::vector<Trajectory> corrected;
  for (const Trajectory& recording : recorded) corrected.push_back(gap::corrected(recording, faults, scale));
  Sounded result;
  result.corrected = gap::prepare(ship, corrected, {});
  result.before = gap::fit_null(result.corrected, {.jobs = 2});
  result.sound = gap::as_sound(result.corrected, gap::prepare(ship, recorded, {}), result.before, faults, scale, 2);
  result.after = gap::fit_null(result.sound, {.jobs = 2}, &result.before);
  return result;
}

struct Told {
  double log_odds;          // of a filter against a latency
  double of_audit;          // the same by what the kinematics predict of what is left out
  gap::Fault filter, late;  // at their likeliest numbers
};

// u, v_m and r once a second, with a fault planted; the simulator is fitted to what a latency of `seconds` leaves.
Told told(const test::Injected& fault, double seconds, std::uint64_t seed) {
  const Ship ship = read_ship("esso-osaka-3m");
  const gap::FroudeScale scale(ship.particulars.L_pp);
  const test::SimulatedCampaign of{
      .ship = "esso-osaka-3m", .seed = seed, .recordings = 3, .duration_s = 240.0, .wind_mps = 0.0};
  const std::vector<Trajectory> recorded = test::recorded(of, ship, fault);
  std::vector<Trajectory> corrected;
  for (const Trajectory& recording : recorded)
    corrected.push_back(gap::corrected(recording, {late_by(seconds)}, scale));
  const gap::FittedNull fit = gap::fit_null(gap::prepare(ship, corrected, {}), {.jobs = 2});
  const gap::SensedCampaign sensed(gap::prepare(ship, recorded, {}), fit, scale, 2);
  std::vector<gap::Fault> filter{filtered_by(seconds)}, late{late_by(seconds)};
  const std::optional<double> of_filter = sensed.fit(filter), of_late = sensed.fit(late);
  REQUIRE(of_filter);
  REQUIRE(of_late);
  double of_audit = 0.0;
  for (const gap::Fault& tried : gap::audit(recorded, {.scale = scale, .jobs = 2}).hypotheses)
    if (tried.parameters.size() == 2 && tried.name == "sensor-filter")
      of_audit += tried.heldout_gain;
    else if (tried.parameters.size() == 2 && tried.name == "velocity-latency")
      of_audit -= tried.heldout_gain;
  return {*of_filter - *of_late, of_audit, filter.front(), late.front()};
}

}  // namespace

TEST_CASE("sensors: where both stand in the measurement function a filter is no latency, nor the other way round",
          "[gap][long]") {
  const double planted_s = 1.4;
  const auto is_near = [&](const gap::Fault& fault) {
    const gap::Estimate& number = fault.parameters.front();
    CHECK(number.sd < 0.1);
    CHECK(std::abs(number.value - planted_s) < 3.0 * number.sd);
  };
  const Told filter = told({.filter_s = planted_s}, 1.2, 1);
  CHECK(filter.log_odds > 3.0);
  is_near(filter.filter);
  const Told late = told({.velocity_latency_s = planted_s, .rate_latency_s = planted_s}, 1.2, 1);
  CHECK(late.log_odds < -3.0);
  is_near(late.late);
}

TEST_CASE("sensors: what a correction left of a fault is found beside the coefficients", "[gap]") {
  // Corrected for 2 deg of 3, and for an arm of which nothing is left.
  const Sounded campaign =
      sounded({.heading_bias = 3.0 * kDegree, .lever_x = 0.3},
              {corrected_for("heading-bias", {{"heading_bias_deg", 2.0, 0.5}}, {1.0}),
               corrected_for("lever-arm", {{"lever_x_m", 0.3, 0.05}, {"lever_y_m", 0.0, 0.05}}, {0.1, 0.1})});
  REQUIRE(campaign.sound.free_faults.size() == 3);
  const gap::FittedNull& fit = campaign.after;
  CHECK(fit.faults == 3);
  CHECK(fit.coefficients() == campaign.before.coefficients());
  CHECK(fit.report.parameters.size() == campaign.before.report.parameters.size());
  const Eigen::VectorXd moved = fit.theta.segment(fit.coefficients(), 3);
  const Eigen::VectorXd sd = gap::posterior_covariance(fit).diagonal().segment(fit.coefficients(), 3).cwiseSqrt();
  CHECK(std::abs(moved[0] - 1.0) < 4.0 * sd[0]);
  CHECK(moved[0] > 4.0 * sd[0]);
  CHECK(std::abs(moved[1]) < 4.0 * sd[1]);
  CHECK(std::abs(moved[2]) < 4.0 * sd[2]);
  CHECK(gap::log_evidence(fit) > gap::log_evidence(campaign.before) + 5.0);
  // Nothing is free where nothing is left open.
  const Sounded as_it_was = sounded({}, {corrected_for("log-scale", {{"log_scale", 0.0, 0.01}}, {})});
  CHECK(as_it_was.sound.free_faults.empty());
  CHECK(as_it_was.after.faults == 0);
}

TEST_CASE("sensors: where a lag is undone in what sensors read, their noise stays what it is", "[gap]") {
  const Sounded campaign = sounded({.filter_s = 1.4}, {[] {
                                     gap::Fault lag = filtered_by(1.4);
                                     lag.left_open = {0.1, 0.1};
                                     return lag;
                                   }()});
  REQUIRE(campaign.after.faults == 1);
  // A shift by fractions of samples takes noise away and correlates what is left, of which samples are left out then.
  const gap::Vec6 &before = campaign.before.noise.measurement_sd, &after = campaign.after.noise.measurement_sd;
  CHECK(after[3] == Approx(0.01).epsilon(0.05));
  CHECK(after[5] == Approx(0.1 * kDegree).epsilon(0.05));
  CHECK(before[3] < 0.9 * after[3]);
  CHECK(campaign.after.total.measurements > campaign.before.total.measurements + 300);
  for (const gap::ParameterShift& p : campaign.after.report.parameters) CHECK(std::abs(p.shift_sd) < 0.5);
}

TEST_CASE("sensors: log-odds of a filter against a latency", "[.measure]") {
  for (const double seconds : {0.5, 0.75, 1.0, 1.4})
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const Told filter = told({.filter_s = seconds}, seconds, seed),
                 late = told({.velocity_latency_s = seconds, .rate_latency_s = seconds}, seconds, seed);
      std::printf(
          "%.2f s, seed %d: filter %+.2f (audit %+.2f; %.3f s, sd %.3f), latency %+.2f (audit %+.2f; %.3f s, sd "
          "%.3f)\n",
          seconds, static_cast<int>(seed), filter.log_odds, filter.of_audit, filter.filter.parameters.front().value,
          filter.filter.parameters.front().sd, late.log_odds, late.of_audit, late.late.parameters.front().value,
          late.late.parameters.front().sd);
    }
}
