#include "gap/sensors/sensor_faults.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

using enum FaultParameter;

constexpr std::array<FaultParameterInfo, kFaultParameterCount> kInfo{{
    {heading_bias, "heading_bias_deg", Quantity::angle, kDegree, kPolicy.sensors.prior_heading_bias_deg* kDegree,
     kPolicy.sensors.usual_heading_bias_deg* kDegree, true, false},
    {lever_x, "lever_x_m", Quantity::length, 1.0, kPolicy.sensors.prior_lever_m, kPolicy.sensors.usual_lever_m, true,
     false},
    {lever_y, "lever_y_m", Quantity::length, 1.0, kPolicy.sensors.prior_lever_m, kPolicy.sensors.usual_lever_m, true,
     false},
    {log_scale, "log_scale", Quantity::ratio, 1.0, kPolicy.sensors.prior_scale, kPolicy.sensors.usual_scale, true,
     false},
    {sway_log_scale, "sway_log_scale", Quantity::ratio, 1.0, kPolicy.sensors.prior_scale, kPolicy.sensors.usual_scale,
     true, false},
    {log_bias_u, "log_bias_u_mps", Quantity::speed, 1.0, kPolicy.sensors.prior_log_bias_mps,
     kPolicy.sensors.usual_log_bias_mps, true, false},
    {log_bias_v, "log_bias_v_mps", Quantity::speed, 1.0, kPolicy.sensors.prior_log_bias_mps,
     kPolicy.sensors.usual_log_bias_mps, true, false},
    {current_x, "current_x_mps", Quantity::speed, 1.0, kPolicy.sensors.prior_current_mps,
     kPolicy.sensors.prior_current_mps, true, false},
    {current_y, "current_y_mps", Quantity::speed, 1.0, kPolicy.sensors.prior_current_mps,
     kPolicy.sensors.prior_current_mps, true, false},
    {velocity_latency, "velocity_latency_s", Quantity::time, 1.0, kPolicy.sensors.prior_delay_s,
     kPolicy.sensors.usual_delay_s, true, false},
    {heading_latency, "heading_latency_s", Quantity::time, 1.0, kPolicy.sensors.prior_delay_s,
     kPolicy.sensors.usual_delay_s, true, true},
    {rate_latency, "rate_latency_s", Quantity::time, 1.0, kPolicy.sensors.prior_delay_s, kPolicy.sensors.usual_delay_s,
     false, true},
    {position_latency, "position_latency_s", Quantity::time, 1.0, kPolicy.sensors.prior_delay_s,
     kPolicy.sensors.usual_delay_s, true, false},
    {rate_bias, "rate_bias_degps", Quantity::angular_rate, kDegree, kPolicy.sensors.prior_rate_bias_degps* kDegree,
     kPolicy.sensors.usual_rate_bias_degps* kDegree, false, true},
    {rate_scale, "rate_scale", Quantity::ratio, 1.0, kPolicy.sensors.prior_scale, kPolicy.sensors.usual_scale, false,
     true},
    {velocity_filter, "filter_s", Quantity::time, 1.0, kPolicy.sensors.prior_delay_s, kPolicy.sensors.usual_delay_s,
     true, false},
    {rate_filter, "rate_filter_s", Quantity::time, 1.0, kPolicy.sensors.prior_delay_s, kPolicy.sensors.usual_delay_s,
     false, true},
    {heading_filter, "heading_filter_s", Quantity::time, 1.0, kPolicy.sensors.prior_delay_s,
     kPolicy.sensors.usual_delay_s, true, true},
}};

}  // namespace

const FaultParameterInfo& info(FaultParameter parameter) { return kInfo[static_cast<std::size_t>(parameter)]; }

const FaultParameterInfo* find_fault_parameter(std::string_view name) {
  const auto* found = std::find_if(kInfo.begin(), kInfo.end(), [&](const auto& known) { return known.name == name; });
  return found == kInfo.end() ? nullptr : found;
}

const std::vector<FaultCandidate>& fault_library() {
  static constexpr FaultTraits kLate{.is_late_only = true};
  static const std::vector<FaultCandidate> library{
      {"heading-bias", {{heading_bias}}},
      {"lever-arm", {{lever_x}, {lever_y}}},
      {"log-scale", {{log_scale}}},
      {"log-scale", {{log_scale, sway_log_scale}}},
      {"log-bias", {{log_bias_u}, {log_bias_v}}, {.simpler = "log-scale"}},
      {"steady-current", {{current_x}, {current_y}}},
      {"velocity-latency", {{velocity_latency}}, kLate},
      {"velocity-latency", {{velocity_latency, rate_latency}}, kLate},
      {"heading-latency", {{heading_latency}}, kLate},
      {"rate-latency", {{rate_latency}}, kLate},
      {"position-latency", {{position_latency}}},
      {"rate-bias", {{rate_bias}}},
      {"rate-scale", {{rate_scale}}},
      {"sensor-filter", {{velocity_filter}}, kLate},
      {"sensor-filter", {{velocity_filter, rate_filter}}, kLate},
      {"sensor-filter", {{velocity_filter, rate_filter, heading_filter}}, kLate},
  };
  return library;
}

const FaultCandidate* candidate_of(const Fault& fault) {
  for (const FaultCandidate& candidate : fault_library()) {
    if (candidate.name != fault.name) continue;
    std::vector<std::string_view> names;
    for (const std::vector<FaultParameter>& number : candidate.numbers)
      for (const FaultParameter parameter : number) names.push_back(info(parameter).name);
    if (std::ranges::equal(names, fault.parameters, {}, {}, &Estimate::name)) return &candidate;
  }
  return nullptr;
}

double log_share_of_name(const Fault& fault) {
  const auto members = std::ranges::count(fault_library(), fault.name, &FaultCandidate::name);
  return -std::log(static_cast<double>(std::max<std::ptrdiff_t>(members, 1)));
}

const FaultTraits& traits_of(std::string_view fault) {
  static constexpr FaultTraits kNone{};
  for (const FaultCandidate& candidate : fault_library())
    if (candidate.name == fault) return candidate.traits;
  return kNone;
}

std::string_view separating_maneuver(std::string_view fault) {
  using Row = std::pair<std::string_view, std::string_view>;
  static constexpr std::array<Row, 12> kManeuvers{{
      {"heading-bias",
       "straight runs there and back: a bias turns both tracks to the same side, a current to one and "
       "the other"},
      {"lever-arm", "the same turn at two speeds: what an arm does goes with the heading, what is late with the speed"},
      {"log-scale", "straight runs there and back at two speeds"},
      {"log-bias", "straight runs there and back at two speeds"},
      {"steady-current", "straight runs there and back, and one across"},
      {"velocity-latency",
       "quick zigzags, sampled several times a second: what is late keeps its peaks, what is "
       "filtered loses them"},
      {"heading-latency", "quick zigzags: the heading against the slope of the track and against the yaw rate"},
      {"rate-latency", "quick zigzags, sampled several times a second: the yaw rate against the slope of the heading"},
      {"position-latency",
       "the same turn at two speeds: what an arm does goes with the heading, what is late with the "
       "speed"},
      {"rate-bias", "a straight run, in which the heading stays"},
      {"rate-scale", "turning circles to both sides"},
      {"sensor-filter",
       "quick zigzags, sampled several times a second: what is late keeps its peaks, what is filtered "
       "loses them"},
  }};
  const auto found =
      std::find_if(kManeuvers.begin(), kManeuvers.end(), [&](const Row& row) { return row.first == fault; });
  return found == kManeuvers.end() ? "" : found->second;
}

SensorFaults sensor_faults(const std::vector<Fault>& faults) {
  SensorFaults result;
  for (const Fault& fault : faults) {
    double speed = 0.0, set = 0.0;
    for (const Estimate& estimate : fault.parameters) {
      if (estimate.name == "current_speed_mps") {
        speed = estimate.value;
        continue;
      }
      if (estimate.name == "current_set_deg") {
        set = estimate.value * kDegree;
        continue;
      }
      const FaultParameterInfo* known = find_fault_parameter(estimate.name);
      if (known == nullptr)
        throw UsageError(fmt::format("the fault '{}' has an unknown parameter '{}'", fault.name, estimate.name));
      result[known->parameter] += estimate.value * known->unit;
    }
    result[current_x] += speed * std::cos(set);
    result[current_y] += speed * std::sin(set);
  }
  return result;
}

}  // namespace leeway::gap
