#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gap/result/sensor_findings.hpp"

/// What the sensors of a recording can have. With (x0, y0), psi, (u, v_m), r the true channels of midship, the
/// recorded ones are
///   (x0, y0)(t) + R(psi) (lever_x, lever_y), late by position_latency
///   psi(t) + heading_bias, passed through a lag of first order (with r through the same), late by heading_latency
///   (1 + log_scale) (u - u_c) + log_bias_u, (1 + sway_log_scale) (v_m - v_c) + log_bias_v, passed through a lag of
///     first order, late by velocity_latency; (u_c, v_c) = R(psi)^T (current_x, current_y)
///   (1 + rate_scale) r + rate_bias, passed through a lag of first order, late by rate_latency
namespace leeway::gap {

enum class FaultParameter : std::size_t {
  heading_bias,
  lever_x,
  lever_y,
  log_scale,
  sway_log_scale,
  log_bias_u,
  log_bias_v,
  current_x,
  current_y,
  velocity_latency,
  heading_latency,
  rate_latency,
  position_latency,
  rate_bias,
  rate_scale,
  velocity_filter,
  rate_filter,
  heading_filter,
};
inline constexpr std::size_t kFaultParameterCount = 18;

/// One value per parameter, SI and radians; all zero: sound sensors.
struct SensorFaults {
  std::array<double, kFaultParameterCount> values{};
  double& operator[](FaultParameter p) { return values[static_cast<std::size_t>(p)]; }
  double operator[](FaultParameter p) const { return values[static_cast<std::size_t>(p)]; }
};

struct FaultParameterInfo {
  FaultParameter parameter;
  std::string_view name;  ///< with its unit; the current's are those of its components
  Quantity quantity;      ///< a latency or a lag, a time, is searched over its whole range
  double unit;            ///< a value in the unit of the name times this is SI
  double prior_sd;        ///< SI, of a ship of 3 m; wide, it only keeps near zero what the recordings do not determine
  double usual_sd;        ///< SI, the same: how large faults are where there are any
  bool in_track;          ///< whether it shows in eta' - R(psi) nu
  bool in_heading;        ///< whether it shows in psi' - r
};
const FaultParameterInfo& info(FaultParameter parameter);
/// Nothing for a name that is none.
const FaultParameterInfo* find_fault_parameter(std::string_view name);

/// What a fault is to those who treat it: they ask these, never its name.
struct FaultTraits {
  /// A negative number would be a sensor ahead of its time. Not of positions: that they are early stands for all others
  /// being late.
  bool is_late_only = false;
  /// The fault with fewer numbers that stands before this one unless it is clearly worse.
  std::string_view simpler = "";
};

/// A member of the library: free numbers, each of which moves one parameter or several by the same value.
struct FaultCandidate {
  std::string_view name;
  std::vector<std::vector<FaultParameter>> numbers;
  FaultTraits traits = {};
};
/// The library. Where two members share a name, the first one is the simpler. A scale of v_m alone is not in it: where
/// a ship hardly drifts, shrinking v_m shrinks its noise, and noise would decide.
const std::vector<FaultCandidate>& fault_library();
/// The member with a fault's name and parameters; nullptr for none of them.
const FaultCandidate* candidate_of(const Fault& fault);
/// ln of a member's part of what a fault has before the recordings are looked at: members of one name share it.
double log_share_of_name(const Fault& fault);
/// Of the first member with this name; those of no fault for other names.
const FaultTraits& traits_of(std::string_view fault);
/// What distinguishes a member of the library from its look-alikes; empty for other names.
std::string_view separating_maneuver(std::string_view fault);

/// The faults of a report as numbers; unknown parameters throw UsageError.
SensorFaults sensor_faults(const std::vector<Fault>& faults);

}  // namespace leeway::gap
