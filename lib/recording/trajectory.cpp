#include "recording/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/statistics.hpp"
#include "core/units.hpp"

namespace leeway {

std::string column_name(Channel channel) {
  const ChannelInfo& i = info(channel);
  return std::string(i.name) + (i.unit.empty() ? "" : "_" + std::string(i.unit));
}

std::string si_name(Channel channel) {
  const ChannelInfo& i = info(channel);
  switch (i.quantity) {
    case Quantity::angle:
      return std::string(i.name) + "_rad";
    case Quantity::angular_rate:
      return std::string(i.name) + "_radps";
    default:
      return column_name(channel);
  }
}

double column_unit(Channel channel) {
  const Quantity quantity = info(channel).quantity;
  return quantity == Quantity::angle || quantity == Quantity::angular_rate ? kDegree : 1.0;
}

std::string found_actuators(const Trajectory& trajectory) {
  std::vector<std::string> found;
  for (const Channel channel : kActuatorChannels)
    if (trajectory.has(channel)) found.push_back(column_name(channel));
  return found.empty() ? "none" : fmt::format("{}", fmt::join(found, ", "));
}

double sampling_time_s(const Trajectory& trajectory) {
  const std::vector<double>& t = trajectory[Channel::t];
  if (t.size() < 2) return 0.0;
  std::vector<double> steps(t.size() - 1);
  for (std::size_t k = 0; k + 1 < t.size(); ++k) steps[k] = t[k + 1] - t[k];
  return median(std::move(steps));
}

bool clock_jumps(const Trajectory& trajectory) {
  const std::vector<double>& t = trajectory[Channel::t];
  if (t.size() < 3) return false;
  const double jump_s = trajectory.longest_step.length_s(), others_s = t.back() - t.front() - jump_s;
  return jump_s > others_s * std::max(1.0, 10.0 / static_cast<double>(t.size() - 2));
}

std::string jump_text(const Trajectory& trajectory) {
  const std::vector<double>& t = trajectory[Channel::t];
  const LongestStep& jump = trajectory.longest_step;
  return fmt::format("from {} s to {} s in one step, while all others last {:.6g} s together", jump.from_s, jump.to_s,
                     t.back() - t.front() - jump.length_s());
}

std::vector<TimeSpan> spans_between_jumps(const Trajectory& trajectory) {
  std::vector<TimeSpan> spans;
  for (const double t : trajectory[Channel::t])
    if (spans.empty() || t - spans.back().to_s > kLongestPause_s)
      spans.push_back({t, t});
    else
      spans.back().to_s = t;
  return spans;
}

double mean_sampling_time_s(const Trajectory& trajectory) {
  const std::vector<double>& t = trajectory[Channel::t];
  if (t.size() < 2) return 0.0;
  if (const double sum = t.back() - t.front(); sum <= kLongestPause_s) return sum / static_cast<double>(t.size() - 1);
  const std::vector<TimeSpan> spans = spans_between_jumps(trajectory);
  double sum = 0.0;
  for (const TimeSpan& span : spans) sum += span.to_s - span.from_s;
  return t.size() > spans.size() ? sum / static_cast<double>(t.size() - spans.size()) : 0.0;
}

bool same_contents(const Trajectory& a, const Trajectory& b) {
  const auto same = [](const std::vector<double>& x, const std::vector<double>& y) {
    return std::equal(x.begin(), x.end(), y.begin(), y.end(),
                      [](double p, double q) { return p == q || (std::isnan(p) && std::isnan(q)); });
  };
  for (std::size_t c = 0; c < kChannelCount; ++c)
    if (!same(a.columns[c], b.columns[c])) return false;
  return true;
}

void unwrap(std::vector<double>& angle) {
  double previous = kMissing, turns = 0.0;
  for (double& a : angle) {
    if (std::isnan(a)) continue;
    const double raw = a;
    if (!std::isnan(previous)) turns -= std::round((raw - previous) / (2.0 * kPi));
    previous = raw;
    a = raw + turns * 2.0 * kPi;
  }
}

}  // namespace leeway
