#include "gap/sensors/force_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/statistics.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/froude_scale.hpp"
#include "gap/sensors/readings.hpp"

namespace leeway::gap {
namespace {

// The blocks of two ways to read, from the windows in which they differ: where a thruster stands still or the wind is
// faint, nothing can be said about it.
struct Compared {
  BlockErrors better, worse;
};
Compared compared(const std::vector<WindowError>& better, const std::vector<WindowError>& worse) {
  std::vector<double> least;
  for (std::size_t w = 0; w < better.size(); ++w)
    if (better[w].allFinite() && worse[w].allFinite()) least.push_back(std::min(better[w].norm(), worse[w].norm()));
  Compared result;
  if (least.empty()) return result;
  const double differing = kPolicy.sensors.differing * median(std::move(least));
  double sum_better = 0.0, sum_worse = 0.0;
  std::size_t count = 0;
  for (std::size_t w = 0; w < better.size(); ++w) {
    if (!better[w].allFinite() || !worse[w].allFinite() || (better[w] - worse[w]).norm() < differing) continue;
    sum_better += better[w].squaredNorm();
    sum_worse += worse[w].squaredNorm();
    if (++count % kPolicy.sensors.windows_per_block != 0) continue;
    result.better.push_back(std::sqrt(sum_better));
    result.worse.push_back(std::sqrt(sum_worse));
    sum_better = sum_worse = 0.0;
  }
  return result;
}

}  // namespace

Odds odds_of(const std::vector<WindowError>& better, const std::vector<WindowError>& worse) {
  const Compared blocks = compared(better, worse);
  return odds_of(blocks.better, blocks.worse);
}

ForceCheck::ForceCheck(const Ship& ship, const std::vector<Trajectory>& recordings) : ship_(ship), model_(ship) {
  horizon_s_ = kPolicy.sensors.force_horizon_s * FroudeScale(ship.particulars.L_pp).time;
  std::size_t possible = 0;
  for (const Trajectory& t : recordings)
    for (const TimeSpan& span : spans_between_jumps(t))
      possible += static_cast<std::size_t>((span.to_s - span.from_s) / horizon_s_);
  const std::size_t every = std::max<std::size_t>(
      1, (possible + kPolicy.sensors.most_force_windows - 1) / kPolicy.sensors.most_force_windows);
  std::array<std::vector<double>, 3> changes;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const Trajectory& t = recordings[i];
    for (const TimeSpan& span : spans_between_jumps(t)) {
      const auto count = static_cast<std::size_t>((span.to_s - span.from_s) / horizon_s_);
      for (std::size_t w = 0; w < count; w += every) {
        const double start = span.from_s + static_cast<double>(w) * horizon_s_;
        const auto from = state_at(t, start), to = state_at(t, start + horizon_s_);
        if (!from || !to) continue;
        windows_.push_back({i, start});
        for (int axis = 0; axis < 3; ++axis)
          changes[static_cast<std::size_t>(axis)].push_back(std::abs(to->nu(axis) - from->nu(axis)));
      }
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double squares = 0.0;
    for (const double change : changes[axis]) squares += change * change;
    spread_(static_cast<Eigen::Index>(axis)) =
        std::max(kPolicy.sensors.least_change,
                 std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, changes[axis].size()))));
  }
}

std::size_t ForceCheck::blocks() const { return windows_.size() / kPolicy.sensors.windows_per_block; }

std::vector<WindowError> ForceCheck::errors(const std::vector<Trajectory>& recordings) const {
  std::vector<RecordedInputs> inputs;
  inputs.reserve(recordings.size());
  for (const Trajectory& recording : recordings)
    inputs.push_back(
        RecordedInputs(recording, ship_, InputInterpolation::at_actuator_rate).through(model_.rudder_response()));
  std::vector<WindowError> result;
  for (const Window& window : windows_)
    result.push_back(error(recordings[window.recording], inputs[window.recording], window.start_s));
  return result;
}

WindowError ForceCheck::error(const Trajectory& recording, const RecordedInputs& inputs, double start_s) const {
  WindowError result = WindowError::Constant(kMissing);
  const auto first = inputs.first_known();
  if (!first || recording[Channel::t][*first] > start_s) return result;
  std::optional<ShipState<double>> state = state_at(recording, start_s);
  const double dt_s = horizon_s_ / kPolicy.sensors.force_steps;
  for (int step = 0; state && step < kPolicy.sensors.force_steps; ++step) {
    const double now = start_s + step * dt_s;
    if (state->nu.allFinite()) *state = integrate(model_, *state, inputs.step(now, dt_s), dt_s);
    if ((step + 1) % (kPolicy.sensors.force_steps / kPolicy.sensors.force_looks) != 0) continue;
    const auto seen = state_at(recording, now + dt_s);
    if (!seen) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const double by_spread = (state->nu(axis) - seen->nu(axis)) / spread_(axis);
      result(3 * ((step + 1) / (kPolicy.sensors.force_steps / kPolicy.sensors.force_looks) - 1) + axis) =
          std::isfinite(by_spread)
              ? std::clamp(by_spread, -kPolicy.sensors.largest_force_error, kPolicy.sensors.largest_force_error)
              : kPolicy.sensors.largest_force_error;
    }
  }
  return result;
}

// The mean of the samples about a time; without a heading it stays zero.
std::optional<ShipState<double>> ForceCheck::state_at(const Trajectory& t, double time) const {
  const std::vector<double>& times = t[Channel::t];
  const double half =
      std::max(kPolicy.sensors.force_node_share * horizon_s_, kPolicy.sensors.node_samples * mean_sampling_time_s(t));
  ShipState<double> sum;
  double count = 0.0;
  for (auto k = static_cast<std::size_t>(std::lower_bound(times.begin(), times.end(), time - half) - times.begin());
       k < times.size() && times[k] <= time + half; ++k) {
    const Vec3<double> nu{t[Channel::u][k], t[Channel::vm][k], t[Channel::r][k]};
    const double psi = t.has(Channel::psi) ? t[Channel::psi][k] : 0.0;
    if (!nu.allFinite() || !std::isfinite(psi)) continue;
    sum.nu += nu;
    sum.eta(2) += psi;
    count += 1.0;
  }
  if (count == 0.0) return std::nullopt;
  sum.nu /= count;
  sum.eta /= count;
  return sum;
}

std::optional<double> typical_force_error(const Ship& ship, const Trajectory& recording) {
  const ForceCheck check(ship, {recording});
  double sum = 0.0, count = 0.0;
  for (const WindowError& error : check.errors({recording}))
    if (error.allFinite()) sum += error.squaredNorm(), count += static_cast<double>(error.size());
  return count > 0.0 ? std::optional(std::sqrt(sum / count)) : std::nullopt;
}

bool is_judged_by_forces(std::string_view channel) {
  const std::optional<Channel> of = channel_of_reading(channel);
  return !of || !is_of_motion(*of);
}

}  // namespace leeway::gap
