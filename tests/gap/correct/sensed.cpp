#include "gap/correct/sensed.hpp"

#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include <catch2/catch.hpp>

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
