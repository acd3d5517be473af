#include "gap/filter/actuator_errors.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "gap/policy/policy.hpp"
#include "gap/sensors/channel_quality.hpp"
#include "recording/samples.hpp"

namespace leeway::gap {

ActuatorErrors::ActuatorErrors(const std::vector<Trajectory>& recordings, const Ship& ship) : recordings_(recordings) {
  for (const Actuator& actuator : ship.actuators) {
    if (known_.size() == kActuatorErrors) break;
    std::vector<double> values;
    for (const Trajectory& recording : recordings)
      values.insert(values.end(), recording[actuator.channel].begin(), recording[actuator.channel].end());
    if (values.empty()) continue;
    const double step = resolution(values);  // orders in steps of 5 deg are no rounding
    const double range = actuator.range();
    const bool counts =
        step > kPolicy.filter.finest_actuator_share * range && step < kPolicy.filter.coarsest_actuator_share * range;
    known_[actuator.channel] = {range, counts ? step : 0.0};
  }
}

std::vector<std::string> ActuatorErrors::notices() const {
  std::vector<std::string> result;
  for (const auto& [channel, known] : known_)
    if (known.step > 0.0)
      result.push_back(fmt::format("'{}' is recorded in steps of {:.3g}: errors of half a step are reckoned with",
                                   column_name(channel), known.step / column_unit(channel)));
  return result;
}

// What bridging would have erred by where nothing is missing: its mean square as far as it goes with that of the change
// from one side to the other, and as far as it does not. An actuator that is where it was has seldom been elsewhere.
//   holds  whether the last known value is held, not a straight line drawn
ActuatorErrors::Bridging ActuatorErrors::bridging(Channel channel, double hole_s, bool holds) const {
  double n = 0.0, e = 0.0, d = 0.0, dd = 0.0, de = 0.0;  // sums; d: squared change, e: squared error
  double count = 0.0, sum = 0.0, squares = 0.0;
  for (const Trajectory& recording : recordings_) {
    const std::vector<double>&x = recording[channel], &t = recording[Channel::t];
    const auto lag = static_cast<std::size_t>(std::lround(hole_s / sampling_time_s(recording)));
    for (const double value : x)
      if (std::isfinite(value)) count += 1.0, sum += value, squares += value * value;
    for (std::size_t i = 0; lag > 1 && i + lag < x.size(); ++i) {
      if (t[i + lag] - t[i] > kPolicy.filter.hole_steps * hole_s) continue;
      const double square = (x[i + lag] - x[i]) * (x[i + lag] - x[i]);
      for (const std::size_t part : {lag / 4, lag / 2, lag - lag / 4}) {
        const double share = holds ? 0.0 : static_cast<double>(part) / static_cast<double>(lag);
        const double error = x[i + part] - x[i] - share * (x[i + lag] - x[i]);
        if (part == 0 || part == lag || !std::isfinite(error + square)) continue;
        n += 1.0, e += error * error, d += square, dd += square * square, de += square * error * error;
      }
    }
  }
  if (n < static_cast<double>(kPolicy.sensors.fewest_for_resolution))  // too few to tell: anywhere
    return {count > 0.0 ? std::max(0.0, squares / count - sum * sum / (count * count)) : 0.0, 0.0};
  const double spread = dd - d * d / n;
  const double slope = spread > 0.0 ? std::max(0.0, (de - d * e / n) / spread) : 0.0, rest = (e - slope * d) / n;
  return rest < 0.0 ? Bridging{0.0, de / dd} : Bridging{rest, slope};
}

std::vector<ActuatorErrors::Hole> ActuatorErrors::holes(const Trajectory& recording, Channel channel, std::size_t first,
                                                        std::size_t end) {
  const std::vector<double>&x = recording[channel], &t = recording[Channel::t];
  const double sample_s = sampling_time_s(recording);
  std::vector<Hole> result;
  std::size_t last = first;
  for (std::size_t i = first; i < end; ++i) {
    if (std::isnan(x[i])) continue;
    if (i > last && !std::isnan(x[last]) && t[i] - t[last] > kPolicy.filter.hole_steps * sample_s) {
      // Missing values are bridged by the last known one, missing samples by a straight line.
      const double hole_s = std::round((t[i] - t[last]) / sample_s) * sample_s;
      const bool is_held = i > last + 1;
      const auto [at, is_new] = bridgings_.try_emplace({channel, hole_s, is_held});
      if (is_new) at->second = bridging(channel, hole_s, is_held);
      const Bridging& of = at->second;
      result.push_back({last, i, std::sqrt(of.rest + of.per_change * (x[i] - x[last]) * (x[i] - x[last]))});
    }
    last = i;
  }
  return result;
}

std::vector<std::pair<double, double>> ActuatorErrors::lost(const Trajectory& recording, double step_s) {
  const std::vector<double>& t = recording[Channel::t];
  std::vector<std::pair<double, double>> result;
  for (const auto& [channel, known] : known_) {
    if (!recording.has(channel)) continue;
    for (const Hole& hole : holes(recording, channel, 0, t.size()))
      if (hole.sd / known.range * (t[hole.after] - t[hole.before]) / step_s > kPolicy.filter.lost_actuator)
        result.emplace_back(t[hole.before], t[hole.after]);
  }
  std::ranges::sort(result);
  result.erase(std::unique(result.begin(), result.end()), result.end());  // those of several actuators
  return result;
}

void ActuatorErrors::set(Stretch& stretch, const Trajectory& recording) {
  const std::vector<double>& t = recording[Channel::t];
  const auto place = [&](double t_s) {  // of the last sample that is not behind t_s
    const auto behind = std::ranges::upper_bound(t, t_s);
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(behind - t.begin(), 1)) - 1;
  };
  const std::size_t first = place(stretch.t_s.front()), end = std::min(place(stretch.t_s.back()) + 2, t.size());
  std::vector<ActuatorError> errors(stretch.size() - 1);
  std::vector<Channel> uncertain;
  for (const auto& [channel, known] : known_) {
    if (!recording.has(channel)) continue;
    const std::vector<double>& x = recording[channel];
    const std::vector<Hole> all = holes(recording, channel, first, end);
    if (known.step == 0.0 && all.empty()) continue;
    const std::size_t a = uncertain.size();
    uncertain.push_back(channel);
    const double rounding_sd = known.step * std::sqrt(kInputShareVariance);
    const Hole* before = nullptr;
    auto next = all.begin();
    for (std::size_t k = 0; k < errors.size(); ++k) {
      const double from_s = stretch.t_s[k], to_s = stretch.t_s[k + 1];
      while (next != all.end() && t[next->after] <= from_s) ++next;
      const Hole* hole = next != all.end() && t[next->before] < to_s ? &*next : nullptr;
      double sd = rounding_sd;
      if (hole != nullptr) {
        const double within_s = std::min(to_s, t[hole->after]) - std::max(from_s, t[hole->before]);
        sd = std::hypot(rounding_sd, hole->sd * within_s / (to_s - from_s));
      }
      errors[k].sd[a] = sd;
      // The same angle is wrong by as much as long as it is shown.
      if (k > 0) errors[k - 1].goes_on[a] = hole == before && (hole != nullptr || x[place(from_s)] == x[place(to_s)]);
      before = hole;
    }
  }
  stretch.uncertain = std::move(uncertain);
  if (!stretch.uncertain.empty()) stretch.actuator_errors = std::move(errors);
}

}  // namespace leeway::gap
