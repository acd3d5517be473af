#include "gap/correct/sensing.hpp"

#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "core/units.hpp"

using namespace leeway;
using gap::FaultParameter;

namespace {

constexpr double kOmega = 0.4;  // [rad/s] of a ship that swings
std::vector<double> times() {
  std::vector<double> t_s;
  for (int k = 0; k <= 480; ++k) t_s.push_back(100.0 + 0.25 * k);
  return t_s;
}
gap::StateVector swing(double t_s) {
  gap::StateVector x = gap::StateVector::Zero();
  x.head<6>() << 3.0 * t_s, -t_s, std::sin(kOmega * t_s), 2.0 + std::cos(kOmega * t_s), 0.5 * std::sin(kOmega * t_s),
      kOmega * std::cos(kOmega * t_s);
  return x;
}
std::vector<gap::StateVector> path() {
  std::vector<gap::StateVector> result;
  for (const double t_s : times()) result.push_back(swing(t_s));
  return result;
}
std::vector<gap::Vec6> read_with(FaultParameter parameter, double value) {
  gap::SensorFaults faults;
  faults[parameter] = value;
  return gap::read_beside(faults, times(), path());
}

}  // namespace

TEST_CASE("sensing: sound sensors add nothing", "[gap]") {
  for (const gap::Vec6& added : gap::read_beside({}, times(), path())) CHECK(added.norm() == 0.0);
}

TEST_CASE("sensing: what is late reads what was, also between the points", "[gap]") {
  const double late_s = 0.7;
  const std::vector<gap::Vec6> added = read_with(FaultParameter::velocity_latency, late_s);
  const std::vector<double> t_s = times();
  for (std::size_t k = 12; k + 12 < t_s.size(); ++k) {
    const gap::Vec6 expected = (swing(t_s[k] - late_s) - swing(t_s[k])).head<6>();
    CHECK(added[k][3] == Approx(expected[3]).margin(2e-3));
    CHECK(added[k][4] == Approx(expected[4]).margin(2e-3));
    CHECK(added[k][5] == 0.0);
    CHECK(added[k].head<3>().norm() == 0.0);
  }
}

TEST_CASE("sensing: a lag of first order lessens a swing and delays it by its transfer function", "[gap]") {
  const double lag_s = 1.3, gain = 1.0 / std::hypot(1.0, kOmega * lag_s), phase = std::atan(kOmega * lag_s);
  const std::vector<gap::Vec6> added = read_with(FaultParameter::rate_filter, lag_s);
  const std::vector<double> t_s = times();
  for (std::size_t k = 60; k < t_s.size(); ++k)  // once the beginning is forgotten
    CHECK(swing(t_s[k])[5] + added[k][5] ==
          Approx(kOmega * gain * std::cos(kOmega * t_s[k] - phase)).margin(kOmega * 2e-3));
}

TEST_CASE("sensing: offsets, factors, an arm and a log through the water, as they are defined", "[gap]") {
  const std::size_t k = 40;
  const gap::StateVector x = path()[k];
  const double c = std::cos(x[2]), s = std::sin(x[2]);
  CHECK(read_with(FaultParameter::heading_bias, 0.1)[k][2] == Approx(0.1));
  CHECK(read_with(FaultParameter::rate_bias, 0.01)[k][5] == Approx(0.01));
  CHECK(read_with(FaultParameter::rate_scale, 0.2)[k][5] == Approx(0.2 * x[5]));
  CHECK(read_with(FaultParameter::log_scale, 0.2)[k][3] == Approx(0.2 * x[3]));
  CHECK(read_with(FaultParameter::sway_log_scale, 0.2)[k][4] == Approx(0.2 * x[4]));
  CHECK(read_with(FaultParameter::log_bias_v, 0.3)[k][4] == Approx(0.3));
  const gap::Vec6 arm = read_with(FaultParameter::lever_y, 2.0)[k],
                  current = read_with(FaultParameter::current_x, 0.5)[k];
  CHECK(arm[0] == Approx(-2.0 * s));
  CHECK(arm[1] == Approx(2.0 * c));
  CHECK(current[3] == Approx(-0.5 * c));
  CHECK(current[4] == Approx(0.5 * s));
}
