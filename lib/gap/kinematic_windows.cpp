#include "gap/kinematic_windows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/types.hpp"
#include "core/units.hpp"

namespace leeway::gap {
namespace {

using enum FaultParameter;

constexpr double kLongestLatency_s = 5.0;
// Recordings are the units of resampling where there are so many of them; else they are cut into about so many blocks.
constexpr std::size_t kEnoughRecordings = 10, kBlocks = 16, kFewestWindowsOfBlock = 2;

// Gauss-Legendre on [0, 1]: the more points the longer the step.
struct Rule {
  std::array<double, 3> at, weight;
  std::size_t points;
};
Rule gauss(double dt_s) {
  if (dt_s < 0.15) return {{0.5, 0.0, 0.0}, {1.0, 0.0, 0.0}, 1};
  if (dt_s < 0.3) {
    const double a = 0.5 / std::numbers::sqrt3;
    return {{0.5 - a, 0.5 + a, 0.0}, {0.5, 0.5, 0.0}, 2};
  }
  const double a = 0.5 * std::sqrt(0.6);
  return {{0.5 - a, 0.5, 0.5 + a}, {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0}, 3};
}

bool is_finite_at(const Trajectory& recording, std::size_t k, Kinematics kind) {
  if (kind == Kinematics::heading) return std::isfinite(recording[Channel::psi][k]);
  return std::isfinite(recording[Channel::x0][k]) && std::isfinite(recording[Channel::y0][k]);
}

}  // namespace

double sampling_time(const Trajectory& recording) {
  const std::vector<double>& t = recording[Channel::t];
  if (t.size() < 2) return 0.0;
  std::vector<double> steps(t.size() - 1);
  for (std::size_t k = 0; k + 1 < t.size(); ++k) steps[k] = t[k + 1] - t[k];
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  return steps[steps.size() / 2];
}

KinematicWindows::KinematicWindows(const std::vector<Trajectory>& recordings, double window_s) {
  double longest_s = 0.0, speed2 = 0.0, rate2 = 0.0, bends2 = 0.0;
  std::size_t speeds = 0, rates = 0, bends = 0;
  for (const Trajectory& recording : recordings) {
    if (recording.size() < 2) continue;
    longest_s = std::max(longest_s, recording[Channel::t].back() - recording[Channel::t].front());
    sample_s_ = std::max(sample_s_, sampling_time(recording));
    if (recording.has(Channel::u) && recording.has(Channel::vm))
      for (std::size_t k = 0; k < recording.size(); ++k) {
        const double U2 = std::pow(recording[Channel::u][k], 2) + std::pow(recording[Channel::vm][k], 2);
        if (std::isfinite(U2)) speed2 += U2, ++speeds;
      }
    const std::vector<double>& r = recording[Channel::r];
    for (std::size_t k = 0; k < r.size(); ++k) {
      if (std::isfinite(r[k])) rate2 += r[k] * r[k], ++rates;
      if (k < 2 || !std::isfinite(r[k] - 2.0 * r[k - 1] + r[k - 2])) continue;
      bends2 += std::pow(r[k] - 2.0 * r[k - 1] + r[k - 2], 2) / 6.0;  // of white noise: its variance
      ++bends;
    }
  }
  rms_speed_ = speeds > 0 ? std::sqrt(speed2 / static_cast<double>(speeds)) : 0.0;
  rms_rate_ = rates > 0 ? std::sqrt(rate2 / static_cast<double>(rates)) : 0.0;
  margin_s_ = std::min(kLongestLatency_s, longest_s / 10.0);
  window_s_ = std::max(window_s, 4.0 * sample_s_);
  if (bends > 0) rate_noise_ = std::sqrt(bends2 / static_cast<double>(bends) * sample_s_ * window_s_);

  std::size_t total = 0, with_windows = 0;
  for (const Trajectory& recording : recordings) {
    Recorded at;
    at.trajectory = &recording;
    at.dt_s = sampling_time(recording);
    const std::vector<double>& t = recording[Channel::t];
    const auto spline = [&](Channel channel) {
      return recording.has(channel) ? Spline(t, recording[channel]) : Spline();
    };
    at.u = spline(Channel::u);
    at.v = spline(Channel::vm);
    at.r = spline(Channel::r);
    at.psi = spline(Channel::psi);
    const double half = std::max(0.05 * window_s_, 0.51 * at.dt_s);
    const double hole_s = std::max(3.5 * at.dt_s, 1.0);
    const double first = t.empty() ? 0.0 : t.front() + margin_s_, last = t.empty() ? 0.0 : t.back() - margin_s_;
    for (std::size_t j = 0; first + static_cast<double>(j) * window_s_ <= last + 1e-9 && t.size() > 1; ++j) {
      const double time = first + static_cast<double>(j) * window_s_;
      const auto begin = std::lower_bound(t.begin(), t.end(), time - half - 1e-9);
      const auto end = std::upper_bound(begin, t.end(), time + half + 1e-9);
      at.nodes.push_back({static_cast<std::size_t>(begin - t.begin()), static_cast<std::size_t>(end - t.begin())});
    }
    for (const Kinematics kind : {Kinematics::track, Kinematics::heading}) {
      std::vector<bool>& is_valid = at.is_valid[static_cast<std::size_t>(kind)];
      const bool is_track = kind == Kinematics::track;
      std::vector<const Spline*> needed{&at.psi};
      if (is_track)
        needed = {&at.psi, &at.u, &at.v};
      else
        needed = {&at.psi, &at.r};
      bool is_there = !is_track || (recording.has(Channel::x0) && recording.has(Channel::y0));
      for (const Spline* spline_of : needed) is_there = is_there && !spline_of->empty();
      const auto has_samples = [&](const Node& node) {
        for (std::size_t k = node.begin; k < node.end; ++k)
          if (is_finite_at(recording, k, kind)) return true;
        return false;
      };
      for (std::size_t j = 0; j + 1 < at.nodes.size(); ++j) {
        bool valid = is_there && has_samples(at.nodes[j]) && has_samples(at.nodes[j + 1]);
        const double start = first + static_cast<double>(j) * window_s_ - margin_s_;
        const double end = start + window_s_ + 2.0 * margin_s_;
        for (const Spline* spline_of : needed) {
          std::size_t place = 0;
          for (double s = start; valid && s <= end; s += 0.5 * hole_s) {
            const double within = std::clamp(s, start + 1e-6, end - 1e-6);
            valid = spline_of->gap(within, place) <= hole_s;
          }
        }
        is_valid.push_back(valid);
      }
    }
    std::size_t count = 0;
    for (std::size_t j = 0; j + 1 < at.nodes.size(); ++j)
      if (at.is_valid[0][j] || at.is_valid[1][j]) ++count;
    total += count;
    if (count > 0) ++with_windows;
    recorded_.push_back(std::move(at));
  }

  units_are_recordings_ = with_windows >= kEnoughRecordings;
  const std::size_t of_block = std::max(kFewestWindowsOfBlock, total / kBlocks);
  for (std::size_t i = 0; i < recorded_.size(); ++i) {
    Recorded& at = recorded_[i];
    const std::size_t windows = at.nodes.empty() ? 0 : at.nodes.size() - 1;
    if (windows == 0) continue;
    const std::size_t units = units_are_recordings_ ? 1 : std::max<std::size_t>(1, windows / of_block);
    at.first_unit = unit_recording_.size();
    at.windows_per_unit = windows / units;
    unit_recording_.insert(unit_recording_.end(), units, i);
    const auto unit_of = [&](std::size_t j) { return at.first_unit + std::min(j / at.windows_per_unit, units - 1); };
    for (const Kinematics kind : {Kinematics::track, Kinematics::heading}) {
      const std::vector<bool>& is_valid = at.is_valid[static_cast<std::size_t>(kind)];
      for (std::size_t j = 0; j < windows;) {
        std::size_t end = j;
        while (end < windows && is_valid[end]) ++end;
        if (end == j) {
          ++j;
          continue;
        }
        segments_.push_back({i, j, end - j, kind, rows_});
        for (int axis = 0; axis < (kind == Kinematics::track ? 2 : 1); ++axis)
          for (std::size_t k = j; k < end;) {
            std::size_t next = k;
            while (next < end && unit_of(next) == unit_of(k)) ++next;
            WindowRun run;
            run.kind = kind;
            run.unit = unit_of(k);
            run.begin = rows_;
            run.size = static_cast<Eigen::Index>(next - k);
            run.is_first_of_unit = k == 0 || unit_of(k - 1) != run.unit;
            run.is_last_of_unit = next == windows || unit_of(next) != run.unit;
            runs_.push_back(run);
            rows_ += run.size;
            k = next;
          }
        j = end;
      }
    }
  }
}

std::size_t KinematicWindows::windows(Kinematics kind) const {
  std::size_t count = 0;
  for (const Segment& segment : segments_)
    if (segment.kind == kind) count += segment.count;
  return count;
}

double KinematicWindows::rms_turned() const {
  double sum = 0.0, count = 0.0;
  for (const Segment& segment : segments_) {
    if (segment.kind != Kinematics::heading) continue;
    const Recorded& at = recorded_[segment.recording];
    const std::vector<double>& t = (*at.trajectory)[Channel::t];
    std::size_t place = 0;
    for (std::size_t j = segment.first_node; j < segment.first_node + segment.count; ++j) {
      const double from = at.psi.value(t[at.nodes[j].begin], place);
      const double to = at.psi.value(t[at.nodes[j + 1].begin], place);
      sum += (to - from) * (to - from);
      count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

Eigen::VectorXd KinematicWindows::residuals(const SensorFaults& faults) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(rows_);
  update(Kinematics::track, faults, result);
  update(Kinematics::heading, faults, result);
  return result;
}

void KinematicWindows::update(Kinematics kind, const SensorFaults& faults, Eigen::VectorXd& residuals) const {
  const double cu = 1.0 / (1.0 + faults[log_scale]), cv = 1.0 / (1.0 + faults[sway_log_scale]);
  const double cr = 1.0 / (1.0 + faults[rate_scale]);
  const bool has_velocity_lag = faults[velocity_filter] != 0.0,
             has_rate_lag = faults[rate_filter] != faults[heading_filter];
  const bool has_lever = faults[lever_x] != 0.0 || faults[lever_y] != 0.0;
  for (const Segment& segment : segments_) {
    if (segment.kind != kind) continue;
    const Recorded& at = recorded_[segment.recording];
    const Trajectory& recording = *at.trajectory;
    const std::vector<double>& t = recording[Channel::t];
    const Rule rule = gauss(at.dt_s);
    std::array<std::size_t, 4> place{};

    // e at the nodes, one after the other; the integral goes along from sample to sample.
    Vec2<double> integral = Vec2<double>::Zero(), before = Vec2<double>::Zero();
    std::size_t sample = at.nodes[segment.first_node].begin;
    const auto rate = [&](double s) -> Vec2<double> {
      if (kind == Kinematics::heading) {
        const double then = s - faults[heading_latency] + faults[rate_latency];
        double r = at.r.value(then, place[2]);
        // The recorded r is the slope of a heading behind the same lag.
        if (has_rate_lag) r += (faults[rate_filter] - faults[heading_filter]) * at.r.slope(then, place[2]);
        return {cr * (r - faults[rate_bias]), 0.0};
      }
      const double now = s - faults[position_latency], then = now + faults[velocity_latency];
      double psi = at.psi.value(now + faults[heading_latency], place[3]) - faults[heading_bias];
      if (faults[heading_filter] != 0.0 && !at.r.empty())
        psi += faults[heading_filter] * at.r.value(now + faults[rate_latency], place[2]);
      double u = at.u.value(then, place[0]), v = at.v.value(then, place[1]);
      if (has_velocity_lag) {
        u += faults[velocity_filter] * at.u.slope(then, place[0]);
        v += faults[velocity_filter] * at.v.slope(then, place[1]);
      }
      u = cu * (u - faults[log_bias_u]);
      v = cv * (v - faults[log_bias_v]);
      const double c = std::cos(psi), si = std::sin(psi);
      return {c * u - si * v + faults[current_x], si * u + c * v + faults[current_y]};
    };
    for (std::size_t j = 0; j <= segment.count; ++j) {
      const Node& node = at.nodes[segment.first_node + j];
      Vec2<double> sum = Vec2<double>::Zero();
      double count = 0.0, reference = 0.0;
      for (std::size_t k = node.begin; k < node.end; ++k) {
        for (; sample < k; ++sample) {
          const double h = t[sample + 1] - t[sample];
          for (std::size_t q = 0; q < rule.points; ++q)
            integral += h * rule.weight[q] * rate(t[sample] + h * rule.at[q]);
        }
        if (!is_finite_at(recording, k, kind)) continue;
        Vec2<double> e;
        if (kind == Kinematics::track) {
          e = {recording[Channel::x0][k], recording[Channel::y0][k]};
          if (has_lever) {
            const double now = t[k] - faults[position_latency] + faults[heading_latency];
            const double psi = at.psi.value(now, place[3]) - faults[heading_bias];
            const double c = std::cos(psi), s = std::sin(psi);
            e -= Vec2<double>(c * faults[lever_x] - s * faults[lever_y], s * faults[lever_x] + c * faults[lever_y]);
          }
        } else {
          // Headings of one node differ by little: a jump of a whole turn is one of counting.
          double psi = recording[Channel::psi][k];
          if (count == 0.0) reference = psi;
          psi = reference + wrap_angle(psi - reference);
          e = {psi, 0.0};
        }
        sum += e - integral;
        count += 1.0;
      }
      const Vec2<double> mean = sum / count;
      if (j > 0) {
        const auto row = segment.begin + static_cast<Eigen::Index>(j - 1);
        const Vec2<double> difference = mean - before;
        if (kind == Kinematics::track) {
          residuals(row) = difference(0);
          residuals(row + static_cast<Eigen::Index>(segment.count)) = difference(1);
        } else {
          residuals(row) = wrap_angle(difference(0));
        }
      }
      before = mean;
    }
  }
}

}  // namespace leeway::gap
