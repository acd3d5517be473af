#include "gap/sensors/audit_faults.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "core/units.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/audit.hpp"
#include "gap/sensors/spline.hpp"

namespace leeway::gap {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using enum FaultParameter;

const char* signed_side(double value, const char* positive, const char* negative) {
  return value > 0.0 ? positive : negative;
}

std::string sentence_of(std::size_t member, const std::vector<Estimate>& e) {
  const FaultCandidate& candidate = fault_library()[member];
  const std::size_t moved = candidate.numbers[0].size();
  const auto late = [&](const std::string& what) {
    return fmt::format("{} are recorded {:.2f} s (sd {:.2f}) too {}", what, std::abs(e[0].value), e[0].sd,
                       signed_side(e[0].value, "late", "early"));
  };
  switch (candidate.numbers[0][0]) {
    case heading_bias:
      return fmt::format("the heading is {:.2f} deg (sd {:.2f}) too {}, or the log is turned by as much to {}",
                         std::abs(e[0].value), e[0].sd, signed_side(e[0].value, "high", "low"),
                         signed_side(e[0].value, "port", "starboard"));
    case lever_x:
    case lever_y:
      return fmt::format(
          "the position is that of a point {:.2f} m (sd {:.2f}) {} of and {:.2f} m (sd {:.2f}) to {} of the one that u "
          "and v_m belong to",
          std::abs(e[0].value), e[0].sd, signed_side(e[0].value, "ahead", "astern"), std::abs(e[1].value), e[1].sd,
          signed_side(e[1].value, "starboard", "port"));
    case log_scale:
      return fmt::format("{} {:.1f} % (sd {:.1f}) too {}", moved > 1 ? "u and v_m are" : "u is",
                         100.0 * std::abs(e[0].value), 100.0 * e[0].sd, signed_side(e[0].value, "high", "low"));
    case sway_log_scale:
      return fmt::format("v_m is {:.1f} % (sd {:.1f}) too {}", 100.0 * std::abs(e[0].value), 100.0 * e[0].sd,
                         signed_side(e[0].value, "high", "low"));
    case log_bias_u:
    case log_bias_v:
      return fmt::format("u is {:+.4f} m/s (sd {:.4f}) and v_m {:+.4f} m/s (sd {:.4f}) off", e[0].value, e[0].sd,
                         e[1].value, e[1].sd);
    case current_x:
    case current_y:
      return fmt::format(
          "u and v_m are measured through the water, which sets towards {:.0f} deg (sd {:.0f}) at {:.4f} m/s (sd "
          "{:.4f})",
          e[1].value, e[1].sd, e[0].value, e[0].sd);
    case velocity_latency:
      return late(moved > 1 ? "u, v_m and r" : "u and v_m");
    case heading_latency:
      return fmt::format("the heading is recorded {:.2f} s (sd {:.2f}) too {}", std::abs(e[0].value), e[0].sd,
                         signed_side(e[0].value, "late", "early"));
    case rate_latency:
      return fmt::format("r is recorded {:.2f} s (sd {:.2f}) too {}", std::abs(e[0].value), e[0].sd,
                         signed_side(e[0].value, "late", "early"));
    case position_latency:
      return late("the positions") + (e[0].value < 0.0 ? ", or all other channels late" : "");
    case rate_bias:
      return fmt::format("r is {:.4f} deg/s (sd {:.4f}) too {}", std::abs(e[0].value), e[0].sd,
                         signed_side(e[0].value, "high", "low"));
    case rate_scale:
      return fmt::format("r is {:.1f} % (sd {:.1f}) too {}", 100.0 * std::abs(e[0].value), 100.0 * e[0].sd,
                         signed_side(e[0].value, "high", "low"));
    case velocity_filter:
    case rate_filter:
    case heading_filter:
      return fmt::format("{} have passed a filter of first order with a time constant of {:.2f} s (sd {:.2f})",
                         moved > 2   ? "u, v_m, r and the heading"
                         : moved > 1 ? "u, v_m and r"
                                     : "u and v_m",
                         e[0].value, e[0].sd);
  }
  return "";
}

// The speed and the direction [rad] of a current, the direction within half a turn of `near`.
VectorXd polar(const Eigen::Ref<const VectorXd>& current, double near) {
  VectorXd result(2);
  result << current.norm(), near + wrap_angle(std::atan2(current(1), current(0)) - near);
  return result;
}

// Recorded channels at shifted times, by splines; missing in holes and beyond the ends.
class ShiftedReader {
 public:
  ShiftedReader(const Trajectory& recording, const FroudeScale& scale)
      : recording_(recording),
        hole_s_(std::max(kPolicy.sensors.samples_of_hole * sampling_time_s(recording),
                         kPolicy.sensors.longest_hole_s * scale.time)) {}

  // A channel at t + latency_s. A lag of first order is undone as a latency: exact to first order, where the inverse of
  // the filter would make every glitch of the sensor several times as large.
  std::vector<double> read(Channel channel, double latency_s) const {
    if (!recording_.has(channel) || latency_s == 0.0) return recording_[channel];
    const std::vector<double>& t = recording_[Channel::t];
    const Spline spline(t, recording_[channel]);
    std::vector<double> values(t.size(), kMissing);
    if (spline.empty()) return values;
    std::size_t place = 0;
    for (std::size_t k = 0; k < t.size(); ++k) {
      const double then = t[k] + latency_s;
      if (spline.gap(then, place) <= hole_s_) values[k] = spline.value(then, place);
    }
    return values;
  }

 private:
  const Trajectory& recording_;
  double hole_s_;
};

// All channels at their own times: latencies and lags are corrected.
Trajectory in_time(const Trajectory& recording, const SensorFaults& fault, const FroudeScale& scale) {
  Trajectory result = recording;
  const ShiftedReader reader(recording, scale);
  result[Channel::psi] = reader.read(Channel::psi, fault[heading_latency]);
  result[Channel::u] = reader.read(Channel::u, fault[velocity_latency] + fault[velocity_filter]);
  result[Channel::vm] = reader.read(Channel::vm, fault[velocity_latency] + fault[velocity_filter]);
  result[Channel::r] = reader.read(Channel::r, fault[rate_latency] + fault[rate_filter]);
  result[Channel::x0] = reader.read(Channel::x0, fault[position_latency]);
  result[Channel::y0] = reader.read(Channel::y0, fault[position_latency]);
  // The recorded r is the slope of a heading behind the same lag.
  if (fault[heading_filter] != 0.0 && recording.has(Channel::psi)) {
    const std::vector<double> slope = reader.read(Channel::r, fault[rate_latency]);
    for (std::size_t k = 0; k < recording.size(); ++k) result[Channel::psi][k] += fault[heading_filter] * slope[k];
  }
  return result;
}

}  // namespace

double size_by_smallest(const FaultCandidate& candidate, const VectorXd& own, const Usual& usual) {
  const double speed = std::max(usual.speed_mps, kPolicy.sensors.least_speed_mps);
  const double rate = std::max(usual.rate_radps, kPolicy.sensors.least_rate_radps);
  const double latency =
      std::max(kPolicy.sensors.smallest_latency_s, kPolicy.sensors.smallest_latency_samples * usual.sample_s);
  const double share = kPolicy.sensors.smallest_share;
  switch (candidate.numbers[0][0]) {
    case heading_bias:
      return std::abs(own(0)) / kPolicy.sensors.smallest_angle_rad;
    case lever_x:
    case lever_y:
      return own.norm() / kPolicy.sensors.smallest_lever_m;
    case log_scale:
    case sway_log_scale:
    case rate_scale:
      return std::abs(own(0)) / share;
    case log_bias_u:
    case log_bias_v:
    case current_x:
    case current_y:
      return own.norm() / (share * speed);
    case velocity_latency:
    case heading_latency:
    case rate_latency:
    case position_latency:
    case velocity_filter:
    case rate_filter:
    case heading_filter:
      return std::abs(own(0)) / latency;
    case rate_bias:
      return std::abs(own(0)) / (share * rate);
  }
  return 0.0;
}

double size_by_smallest(const FaultFitter& fitter, const FaultFit& fit, std::size_t place) {
  const KinematicWindows& windows = fitter.windows();
  return size_by_smallest(fault_library()[fit.members[place]], fitter.own_numbers(fit, place),
                          {windows.rms_speed(), windows.rms_rate(), windows.sample_s()});
}

Fault fault_of(const FaultFitter& fitter, const FaultFit& fit, std::size_t place, const RandomStream& stream,
               const FroudeScale& scale) {
  Index begin = 0;
  for (std::size_t m = 0; m < place; ++m) begin += FaultFitter::size_of(fit.members[m]);
  const Index size = FaultFitter::size_of(fit.members[place]);
  const FaultCandidate& candidate = fault_library()[fit.members[place]];
  const bool is_current = candidate.numbers[0][0] == current_x;
  const double set = is_current ? std::atan2(fit.numbers(begin + 1), fit.numbers(begin)) : 0.0;
  const auto reported = [&](const VectorXd& numbers) -> VectorXd {
    if (is_current) return polar(numbers.segment(begin, size), set);
    return numbers.segment(begin, size);
  };
  const VectorXd value = reported(fit.numbers), sd = fitter.resampled_sd(fit, stream, reported);
  Fault fault;
  fault.name = candidate.name;
  if (is_current) {
    const double positive = value(1) < 0.0 ? value(1) + 2.0 * kPi : value(1);
    fault.parameters = {{"current_speed_mps", value(0) * scale.of(Quantity::speed), sd(0) * scale.of(Quantity::speed)},
                        {"current_set_deg", rad_to_deg(positive), rad_to_deg(sd(1))}};
  } else {
    for (std::size_t n = 0; n < candidate.numbers.size(); ++n)
      for (const FaultParameter parameter : candidate.numbers[n]) {
        const FaultParameterInfo& of = info(parameter);
        const auto k = static_cast<Index>(n);
        const double by = scale.of(of.quantity);
        fault.parameters.push_back({std::string(of.name), value(k) * by / of.unit, sd(k) * by / of.unit});
      }
  }
  fault.sentence = sentence_of(fit.members[place], fault.parameters);
  fault.separating_maneuver = separating_maneuver(candidate.name);
  return fault;
}

void rephrase(Fault& fault) {
  if (const FaultCandidate* candidate = candidate_of(fault))
    fault.sentence = sentence_of(static_cast<std::size_t>(candidate - fault_library().data()), fault.parameters);
}

Trajectory corrected(const Trajectory& recording, const std::vector<Fault>& faults, const FroudeScale& scale) {
  const SensorFaults fault = sensor_faults(faults);
  Trajectory result = in_time(recording, fault, scale);
  for (double& psi : result[Channel::psi]) psi -= fault[heading_bias];
  for (double& u : result[Channel::u]) u = (u - fault[log_bias_u]) / (1.0 + fault[log_scale]);
  for (double& v : result[Channel::vm]) v = (v - fault[log_bias_v]) / (1.0 + fault[sway_log_scale]);
  for (double& r : result[Channel::r]) r = (r - fault[rate_bias]) / (1.0 + fault[rate_scale]);
  if (!recording.has(Channel::psi)) return result;
  const bool has_current = fault[current_x] != 0.0 || fault[current_y] != 0.0;
  const bool has_lever = fault[lever_x] != 0.0 || fault[lever_y] != 0.0;
  for (std::size_t k = 0; k < recording.size(); ++k) {
    const double c = std::cos(result[Channel::psi][k]), s = std::sin(result[Channel::psi][k]);
    if (has_current && recording.has(Channel::u) && recording.has(Channel::vm)) {
      result[Channel::u][k] += c * fault[current_x] + s * fault[current_y];
      result[Channel::vm][k] += -s * fault[current_x] + c * fault[current_y];
    }
    if (has_lever && recording.has(Channel::x0) && recording.has(Channel::y0)) {
      result[Channel::x0][k] -= c * fault[lever_x] - s * fault[lever_y];
      result[Channel::y0][k] -= s * fault[lever_x] + c * fault[lever_y];
    }
  }
  return result;
}

}  // namespace leeway::gap
