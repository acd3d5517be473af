#include "gap/sensors/channel_quality.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/linear_algebra.hpp"
#include "core/statistics.hpp"
#include "gap/policy/policy.hpp"
#include "gap/result/numbers.hpp"
#include "gap/sensors/kinematic_windows.hpp"

namespace leeway::gap {
namespace {

constexpr std::array kMotion{Channel::u, Channel::vm, Channel::r, Channel::x0, Channel::y0, Channel::psi};

// Residual maker of a cubic through n equidistant samples.
Eigen::MatrixXd cubic_residual(Eigen::Index n) {
  Eigen::MatrixXd powers(n, 4);
  for (Eigen::Index k = 0; k < n; ++k)
    for (Eigen::Index p = 0; p < 4; ++p)
      powers(k, p) = std::pow(2.0 * static_cast<double>(k) / static_cast<double>(n - 1) - 1.0, p);
  const Eigen::MatrixXd hat = powers * (powers.transpose() * powers).inverse() * powers.transpose();
  return Eigen::MatrixXd::Identity(n, n) - hat;
}

// Expected sum of squares and of lag-one products of the residuals, for AR(1) noise of unit variance.
std::array<double, 2> expected_moments(const Eigen::MatrixXd& maker, double phi) {
  Eigen::MatrixXd covariance(maker.rows(), maker.rows());
  for (Eigen::Index i = 0; i < maker.rows(); ++i)
    for (Eigen::Index j = 0; j < maker.rows(); ++j) covariance(i, j) = std::pow(phi, std::abs(i - j));
  const Eigen::MatrixXd left = maker * covariance * maker.transpose();
  return {left.trace(), left.diagonal(1).sum()};
}

void measure_noise(const std::vector<const std::vector<double>*>& series, double dt_s, const FroudeScale& scale,
                   ChannelQuality& quality) {
  std::vector<double> squares, ratios;
  const auto size = static_cast<std::size_t>(std::clamp<double>(
      kPolicy.sensors.cubic_s * scale.time / std::max(dt_s, kPolicy.sensors.least_sampling_s * scale.time),
      static_cast<double>(kPolicy.sensors.shortest_cubic), static_cast<double>(kPolicy.sensors.longest_cubic)));
  const auto n = static_cast<Eigen::Index>(size);
  const Eigen::MatrixXd maker = cubic_residual(n);
  for (const std::vector<double>* x : series)
    for (std::size_t begin = 0; begin + size <= x->size(); begin += size / 2) {
      const Eigen::Map<const Eigen::VectorXd> stretch(x->data() + begin, n);
      if (!stretch.allFinite()) continue;
      const Eigen::VectorXd rest = maker * (stretch.array() - stretch(0)).matrix();
      const double square = rest.squaredNorm();
      squares.push_back(square);
      if (square > 0.0) ratios.push_back(rest.head(n - 1).dot(rest.tail(n - 1)) / square);
    }
  if (squares.size() < kPolicy.sensors.fewest_for_noise || ratios.size() < kPolicy.sensors.fewest_for_noise) return;
  const double observed = median(ratios);
  double low = 0.0, high = kPolicy.sensors.highest_phi;
  for (int i = 0; i < kPolicy.sensors.bisections; ++i) {
    const double phi = 0.5 * (low + high);
    const auto [square, product] = expected_moments(maker, phi);
    (product / square < observed ? low : high) = phi;
  }
  const double phi = 0.5 * (low + high);
  const double freedom = static_cast<double>(n - 4);
  // The median of a chi-squared variable by its mean, after Wilson and Hilferty.
  const double of_median = std::pow(1.0 - 2.0 / (9.0 * freedom), 3);
  quality.noise_sd = std::sqrt(median(squares) / of_median / expected_moments(maker, phi)[0]);
  // Noise that lasts longer than the stretch cannot be distinguished from the ship's motion.
  if (phi > kPolicy.sensors.visible_correlation && phi < kPolicy.sensors.longest_correlation)
    quality.correlation_s = -dt_s / std::log(phi);
  quality.filter_s = quality.correlation_s;
}

struct Repeats {
  std::size_t begin, end;
};

// Runs of one value. Missing samples end a run.
std::vector<Repeats> repeats(const std::vector<double>& t, const std::vector<double>& x, const FroudeScale& scale) {
  std::vector<Repeats> runs;
  for (std::size_t k = 0; k < x.size();) {
    std::size_t end = k + 1;
    while (end < x.size() && x[end] == x[k]) ++end;
    if (std::isfinite(x[k]) && end - k >= kPolicy.sensors.fewest_repeats &&
        t[end - 1] - t[k] >= kPolicy.sensors.shortest_frozen_s * scale.time)
      runs.push_back({k, end});
    k = end;
  }
  return runs;
}

// Largest |x| of a channel over a run, 0 where it is not recorded.
double largest(const Trajectory& recording, Channel channel, const Repeats& run) {
  double value = 0.0;
  if (recording.has(channel))
    for (std::size_t k = run.begin; k < run.end; ++k)
      if (std::isfinite(recording[channel][k])) value = std::max(value, std::abs(recording[channel][k]));
  return value;
}

bool changes(const Trajectory& recording, Channel channel, const Repeats& run) {
  if (!recording.has(channel)) return false;
  const std::vector<double>& x = recording[channel];
  for (std::size_t k = run.begin + 1; k < run.end; ++k)
    if (std::isfinite(x[k]) && std::isfinite(x[k - 1]) && x[k] != x[k - 1]) return true;
  return false;
}

// Whether a velocity that is constant for most of a recording cannot have been: u and v_m when the ship turned to and
// fro by 0.3 rad meanwhile, r when the heading says so.
bool has_turned(const Trajectory& recording, Channel velocity, const Repeats& run) {
  const std::vector<double>&t = recording[Channel::t], &r = recording[Channel::r], &psi = recording[Channel::psi];
  double turned = 0.0, by_heading = 0.0, lowest = 0.0, highest = 0.0, first_psi = kMissing;
  for (std::size_t k = run.begin; k + 1 < run.end; ++k) {
    if (std::isfinite(r[k])) turned += r[k] * (t[k + 1] - t[k]);
    if (!psi.empty() && std::isfinite(psi[k])) {
      if (std::isnan(first_psi)) first_psi = psi[k];
      by_heading = psi[k] - first_psi;
    }
    const double at = velocity == Channel::r ? by_heading - turned : turned;
    lowest = std::min(lowest, at);
    highest = std::max(highest, at);
  }
  return highest - lowest > kPolicy.sensors.turned_rad;
}

std::vector<Repeats> frozen_runs(const Trajectory& recording, Channel channel, const FroudeScale& scale) {
  const std::vector<double>&t = recording[Channel::t], &x = recording[channel];
  std::vector<Repeats> frozen;
  const double step = resolution(x);
  for (const Repeats& run : repeats(t, x, scale)) {
    const double duration_s = t[run.end - 1] - t[run.begin];
    const double speed = std::hypot(largest(recording, Channel::u, run), largest(recording, Channel::vm, run));
    const double rate = largest(recording, Channel::r, run);
    bool should_move = false;
    if (channel == Channel::x0 || channel == Channel::y0) {
      // How far the ship went along this axis by its velocity; a heading is needed to tell.
      double moved = 0.0, farthest = 0.0;
      for (std::size_t k = run.begin; recording.has(Channel::psi) && k + 1 < run.end; ++k) {
        const double psi = recording[Channel::psi][k], u = recording[Channel::u][k], v = recording[Channel::vm][k];
        const double along =
            channel == Channel::x0 ? u * std::cos(psi) - v * std::sin(psi) : u * std::sin(psi) + v * std::cos(psi);
        if (std::isfinite(along)) moved += along * (t[k + 1] - t[k]);
        farthest = std::max(farthest, std::abs(moved));
      }
      should_move =
          farthest > std::max(kPolicy.sensors.frozen_steps * step, kPolicy.sensors.frozen_track * speed * duration_s);
    } else if (channel == Channel::psi) {
      should_move = rate * duration_s > kPolicy.sensors.frozen_steps * step && changes(recording, Channel::r, run);
    } else {
      // In a steady motion all three velocities are constant.
      bool others = false;
      for (const Channel velocity : {Channel::u, Channel::vm, Channel::r})
        if (velocity != channel) others = others || changes(recording, velocity, run);
      // A quantized channel repeats its values by itself: it has to stay longer than it ever takes for two steps.
      std::vector<double> moved;
      const std::size_t lag = run.end - run.begin;
      for (std::size_t k = 0; k + lag < x.size(); k += std::max<std::size_t>(1, lag / 4))
        if (std::isfinite(x[k]) && std::isfinite(x[k + lag])) moved.push_back(std::abs(x[k + lag] - x[k]));
      should_move =
          others && (2 * lag > x.size() ? has_turned(recording, channel, run)
                                        : median(moved) > kPolicy.sensors.frozen_steps * step && median(moved) > 0.0);
    }
    if (should_move) frozen.push_back(run);
  }
  return frozen;
}

}  // namespace

double resolution(const std::vector<double>& values) {
  std::vector<double> sorted;
  for (const double x : values)
    if (std::isfinite(x)) sorted.push_back(x);
  std::sort(sorted.begin(), sorted.end());
  const std::size_t samples = sorted.size();
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  if (samples < kPolicy.sensors.fewest_for_resolution || sorted.size() < 3 || 2 * sorted.size() > samples) return 0.0;
  // Values that were read from text differ in the last digits.
  const double spread = sorted.back() - sorted.front();
  double step = spread;
  for (std::size_t k = 1; k < sorted.size(); ++k)
    if (sorted[k] - sorted[k - 1] > kPolicy.sensors.same_value * spread)
      step = std::min(step, sorted[k] - sorted[k - 1]);
  for (std::size_t k = 1; k < sorted.size(); ++k) {
    const double steps = (sorted[k] - sorted[k - 1]) / step;
    if (std::abs(steps - std::round(steps)) > kPolicy.sensors.same_step) return 0.0;
  }
  return step;
}

std::vector<ChannelQuality> channel_qualities(const std::vector<Trajectory>& recordings, const FroudeScale& scale) {
  std::vector<ChannelQuality> result;
  for (const Channel channel : kMotion) {
    ChannelQuality quality;
    quality.channel = channel;
    std::vector<const std::vector<double>*> series;
    std::vector<double> values, steps;
    std::size_t samples = 0, missing = 0, frozen = 0;
    for (const Trajectory& recording : recordings) {
      if (!recording.has(channel)) continue;
      const std::vector<double>& x = recording[channel];
      samples += x.size();
      for (const double value : x)
        if (!std::isfinite(value)) ++missing;
      const std::vector<Repeats> runs = frozen_runs(recording, channel, scale);
      for (const Repeats& run : runs) frozen += run.end - run.begin;
      if (!runs.empty()) quality.frozen_in.push_back(recording.name);
      values.insert(values.end(), x.begin(), x.end());
      series.push_back(&x);
      steps.push_back(sampling_time_s(recording));
    }
    if (samples == 0) continue;
    quality.missing_share = static_cast<double>(missing) / static_cast<double>(samples);
    quality.frozen_share = static_cast<double>(frozen) / static_cast<double>(samples);
    quality.resolution = resolution(values);
    measure_noise(series, median(steps), scale, quality);
    result.push_back(quality);
  }
  return result;
}

bool is_at_rest(const Trajectory& recording) {
  return std::all_of(kMotion.begin(), kMotion.end(), [&](Channel channel) {
    const std::vector<double>& x = recording[channel];
    const auto first = std::find_if(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
    return std::all_of(first, x.end(), [&](double value) { return std::isnan(value) || value == *first; });
  });
}

std::vector<std::string> suspect_actuators(const Trajectory& recording, const FroudeScale& scale) {
  std::vector<std::string> result;
  const std::vector<double>& t = recording[Channel::t];
  for (const Channel channel : kActuatorChannels) {
    if (!recording.has(channel)) continue;
    const std::vector<double>& x = recording[channel];
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double value : x)
      if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
    const std::vector<Repeats> runs = repeats(t, x, scale);
    const auto longest = std::max_element(
        runs.begin(), runs.end(), [](const Repeats& a, const Repeats& b) { return a.end - a.begin < b.end - b.begin; });
    if (longest == runs.end() || longest->end - longest->begin < kPolicy.sensors.fewest_suspect) continue;
    if (x[longest->begin] == low || x[longest->begin] == high) continue;  // it may be at its stop
    std::size_t changes = 0, repeats_elsewhere = 0;
    for (std::size_t k = 1; k < x.size(); ++k)
      if ((k <= longest->begin || k >= longest->end) && std::isfinite(x[k]) && std::isfinite(x[k - 1]))
        ++(x[k] == x[k - 1] ? repeats_elsewhere : changes);
    if (changes < kPolicy.sensors.fewest_changes ||
        static_cast<double>(repeats_elsewhere) > kPolicy.sensors.most_unchanged * static_cast<double>(changes))
      continue;
    result.push_back(fmt::format(
        "'{}' keeps one value from {:.4g} to {:.4g} s although it changes from sample to sample elsewhere: it may be "
        "frozen; it is used as it is",
        column_name(channel), t[longest->begin], t[longest->end - 1]));
  }
  return result;
}

std::string frozen_text(const ChannelQuality& quality) {
  return fmt::format("{} is frozen in {} of its samples although the ship moves ({}): they are left out",
                     info(quality.channel).name, percent(quality.frozen_share), fmt::join(quality.frozen_in, ", "));
}

Trajectory without_frozen(const Trajectory& recording, const FroudeScale& scale) {
  Trajectory result = recording;
  for (const Channel channel : kMotion)
    if (recording.has(channel))
      for (const Repeats& run : frozen_runs(recording, channel, scale))
        for (std::size_t k = run.begin + 1; k < run.end; ++k) result[channel][k] = kMissing;
  return result;
}

}  // namespace leeway::gap
