#include "gap/sensors/kinematic_windows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/types.hpp"
#include "core/units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

using enum FaultParameter;

// Gauss-Legendre on [0, 1]: the more points the longer the step.
struct Rule {
  std::array<double, 3> at, weight;
  std::size_t points;
};
Rule gauss(double dt_s) {
  if (dt_s < kPolicy.sensors.one_point_s) return {{0.5, 0.0, 0.0}, {1.0, 0.0, 0.0}, 1};
  if (dt_s < kPolicy.sensors.two_points_s) {
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

KinematicWindows::KinematicWindows(const std::vector<Trajectory>& recordings) {
  measure(recordings);
  for (const Trajectory& recording : recordings) recorded_.push_back(read(recording));
  std::size_t total = 0, with_windows = 0;
  for (const Recorded& at : recorded_) {
    std::size_t count = 0;
    for (std::size_t j = 0; j + 1 < at.nodes.size(); ++j)
      if (at.is_valid[0][j] || at.is_valid[1][j]) ++count;
    total += count;
    if (count > 0) ++with_windows;
  }
  units_are_recordings_ = with_windows >= kPolicy.sensors.enough_recordings;
  const std::size_t of_block = std::max(kPolicy.sensors.fewest_windows_of_block, total / kPolicy.sensors.blocks);
  for (std::size_t i = 0; i < recorded_.size(); ++i) {
    Recorded& at = recorded_[i];
    const std::size_t windows = at.nodes.empty() ? 0 : at.nodes.size() - 1;
    if (windows == 0) continue;
    at.units = units_are_recordings_ ? 1 : std::max<std::size_t>(1, windows / of_block);
    at.first_unit = unit_recording_.size();
    at.windows_per_unit = windows / at.units;
    unit_recording_.insert(unit_recording_.end(), at.units, i);
    for (const Kinematics kind : {Kinematics::track, Kinematics::heading}) add_segments(i, kind);
  }
}

// The sampling time, how fast the ships were and turned, and the noise of r.
void KinematicWindows::measure(const std::vector<Trajectory>& recordings) {
  double longest_s = 0.0, speed2 = 0.0, rate2 = 0.0, differences2 = 0.0;
  std::size_t speeds = 0, rates = 0, differences = 0;
  for (const Trajectory& recording : recordings) {
    if (recording.size() < 2) continue;
    longest_s = std::max(longest_s, recording[Channel::t].back() - recording[Channel::t].front());
    sample_s_ = std::max(sample_s_, sampling_time_s(recording));
    if (recording.has(Channel::u) && recording.has(Channel::vm))
      for (std::size_t k = 0; k < recording.size(); ++k) {
        const double U2 = std::pow(recording[Channel::u][k], 2) + std::pow(recording[Channel::vm][k], 2);
        if (std::isfinite(U2)) speed2 += U2, ++speeds;
      }
    const std::vector<double>& r = recording[Channel::r];
    for (std::size_t k = 0; k < r.size(); ++k) {
      if (std::isfinite(r[k])) rate2 += r[k] * r[k], ++rates;
      if (k < 2 || !std::isfinite(r[k] - 2.0 * r[k - 1] + r[k - 2])) continue;
      differences2 += std::pow(r[k] - 2.0 * r[k - 1] + r[k - 2], 2) / 6.0;  // of white noise: its variance
      ++differences;
    }
  }
  rms_speed_ = speeds > 0 ? std::sqrt(speed2 / static_cast<double>(speeds)) : 0.0;
  rms_rate_ = rates > 0 ? std::sqrt(rate2 / static_cast<double>(rates)) : 0.0;
  margin_s_ = std::min(kPolicy.sensors.longest_latency_s, longest_s / kPolicy.sensors.recording_by_latency);
  window_s_ = std::max(kPolicy.sensors.window_s, kPolicy.sensors.samples_of_window * sample_s_);
  if (differences > 0) rate_noise_ = std::sqrt(differences2 / static_cast<double>(differences) * sample_s_ * window_s_);
}

// One recording with its splines, the nodes between windows, and which windows are whole.
KinematicWindows::Recorded KinematicWindows::read(const Trajectory& recording) const {
  Recorded at;
  at.trajectory = &recording;
  at.dt_s = sampling_time_s(recording);
  const std::vector<double>& t = recording[Channel::t];
  const auto spline = [&](Channel channel) {
    return recording.has(channel) ? Spline(t, recording[channel]) : Spline();
  };
  at.u = spline(Channel::u);
  at.v = spline(Channel::vm);
  at.r = spline(Channel::r);
  at.psi = spline(Channel::psi);
  const double half = std::max(kPolicy.sensors.node_share * window_s_, kPolicy.sensors.node_samples * at.dt_s);
  std::size_t place = 0;
  for (const TimeSpan& span : spans_between_jumps(recording)) {
    const double first = span.from_s + margin_s_, last = span.to_s - margin_s_;
    for (std::size_t j = 0;
         first + static_cast<double>(j) * window_s_ <= last + kPolicy.sensors.same_time_s && t.size() > 1; ++j) {
      const double time = first + static_cast<double>(j) * window_s_;
      const auto begin = std::lower_bound(t.begin(), t.end(), time - half - kPolicy.sensors.same_time_s);
      const auto end = std::upper_bound(begin, t.end(), time + half + kPolicy.sensors.same_time_s);
      at.nodes.push_back(
          {static_cast<std::size_t>(begin - t.begin()), static_cast<std::size_t>(end - t.begin()), time, place});
    }
    ++place;
  }
  const bool has_track = recording.has(Channel::x0) && recording.has(Channel::y0);
  at.is_valid = {whole_windows(at, Kinematics::track, {&at.psi, &at.u, &at.v}, has_track),
                 whole_windows(at, Kinematics::heading, {&at.psi, &at.r}, true)};
  return at;
}

// Which windows have samples at both ends and no hole in a channel that they need.
std::vector<bool> KinematicWindows::whole_windows(const Recorded& at, Kinematics kind,
                                                  const std::vector<const Spline*>& needed, bool is_there) const {
  for (const Spline* spline : needed) is_there = is_there && !spline->empty();
  const auto has_samples = [&](const Node& node) {
    for (std::size_t k = node.begin; k < node.end; ++k)
      if (is_finite_at(*at.trajectory, k, kind)) return true;
    return false;
  };
  const double hole_s = std::max(kPolicy.sensors.samples_of_hole * at.dt_s, kPolicy.sensors.longest_hole_s);
  std::vector<bool> is_valid;
  for (std::size_t j = 0; j + 1 < at.nodes.size(); ++j) {
    bool valid = is_there && has_samples(at.nodes[j]) && has_samples(at.nodes[j + 1]);
    valid = valid && at.nodes[j].span == at.nodes[j + 1].span;
    const double start = at.nodes[j].time_s - margin_s_;
    const double end = start + window_s_ + 2.0 * margin_s_;
    for (const Spline* spline : needed) {
      std::size_t place = 0;
      for (double s = start; valid && s <= end; s += 0.5 * hole_s) {
        const double within = std::clamp(s, start + kPolicy.sensors.within_step_s, end - kPolicy.sensors.within_step_s);
        valid = spline->gap(within, place) <= hole_s;
      }
    }
    is_valid.push_back(valid);
  }
  return is_valid;
}

// Runs of whole windows side by side, a row each.
void KinematicWindows::add_segments(std::size_t recording, Kinematics kind) {
  const Recorded& at = recorded_[recording];
  const std::size_t windows = at.nodes.size() - 1;
  const auto unit_of = [&](std::size_t j) { return at.first_unit + std::min(j / at.windows_per_unit, at.units - 1); };
  const std::vector<bool>& is_valid = at.is_valid[static_cast<std::size_t>(kind)];
  for (std::size_t j = 0; j < windows;) {
    std::size_t end = j;
    while (end < windows && is_valid[end]) ++end;
    if (end == j) {
      ++j;
      continue;
    }
    segments_.push_back({recording, j, end - j, kind, rows_});
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

// A recording as its sensors would read without these faults; the places in the splines move along with time.
class KinematicWindows::Reader {
 public:
  Reader(const Recorded& at, const SensorFaults& faults) : at_(at), faults_(faults) {}

  /// d psi/dt, or the velocity over ground in earth axes.
  Vec2<double> rate(Kinematics kind, double s) {
    if (kind == Kinematics::heading) {
      const double then = s - faults_[heading_latency] + faults_[rate_latency];
      double r = at_.r.value(then, place_[2]);
      // The recorded r is the slope of a heading behind the same lag.
      if (has_rate_lag_) r += (faults_[rate_filter] - faults_[heading_filter]) * slope(at_.r, then, place_[2]);
      return {cr_ * (r - faults_[rate_bias]), 0.0};
    }
    const double now = s - faults_[position_latency], then = now + faults_[velocity_latency];
    double psi = at_.psi.value(now + faults_[heading_latency], place_[3]) - faults_[heading_bias];
    if (faults_[heading_filter] != 0.0 && !at_.r.empty())
      psi += faults_[heading_filter] * at_.r.value(now + faults_[rate_latency], place_[2]);
    double u = at_.u.value(then, place_[0]), v = at_.v.value(then, place_[1]);
    if (has_velocity_lag_) {
      u += faults_[velocity_filter] * slope(at_.u, then, place_[0]);
      v += faults_[velocity_filter] * slope(at_.v, then, place_[1]);
    }
    u = cu_ * (u - faults_[log_bias_u]);
    v = cv_ * (v - faults_[log_bias_v]);
    const double c = std::cos(psi), si = std::sin(psi);
    return {c * u - si * v + faults_[current_x], si * u + c * v + faults_[current_y]};
  }
  /// Midship at a sample: where the position sensor is, less its lever arm.
  Vec2<double> position(std::size_t k) {
    const Trajectory& recording = *at_.trajectory;
    Vec2<double> e{recording[Channel::x0][k], recording[Channel::y0][k]};
    if (has_lever_) {
      const double now = recording[Channel::t][k] - faults_[position_latency] + faults_[heading_latency];
      const double psi = at_.psi.value(now, place_[3]) - faults_[heading_bias];
      const double c = std::cos(psi), s = std::sin(psi);
      e -= Vec2<double>(c * faults_[lever_x] - s * faults_[lever_y], s * faults_[lever_x] + c * faults_[lever_y]);
    }
    return e;
  }

 private:
  // From the sample before to the one after: what undoes a filter would make noise larger by the slope between two.
  double slope(const Spline& channel, double now, std::size_t& place) const {
    const std::vector<double>& t = (*at_.trajectory)[Channel::t];
    const double from = std::max(now - at_.dt_s, t.front()), to = std::min(now + at_.dt_s, t.back());
    if (!(from < to)) return 0.0;
    const double before = channel.value(from, place);
    return (channel.value(to, place) - before) / (to - from);
  }

  const Recorded& at_;
  const SensorFaults& faults_;
  const double cu_ = 1.0 / (1.0 + faults_[log_scale]), cv_ = 1.0 / (1.0 + faults_[sway_log_scale]);
  const double cr_ = 1.0 / (1.0 + faults_[rate_scale]);
  const bool has_velocity_lag_ = faults_[velocity_filter] != 0.0;
  const bool has_rate_lag_ = faults_[rate_filter] != faults_[heading_filter];
  const bool has_lever_ = faults_[lever_x] != 0.0 || faults_[lever_y] != 0.0;
  std::array<std::size_t, 4> place_{};
};

void KinematicWindows::update(Kinematics kind, const SensorFaults& faults, Eigen::VectorXd& residuals) const {
  for (const Segment& segment : segments_)
    if (segment.kind == kind) update(segment, faults, residuals);
}

void KinematicWindows::update(const Segment& segment, const SensorFaults& faults, Eigen::VectorXd& residuals) const {
  const Kinematics kind = segment.kind;
  const Recorded& at = recorded_[segment.recording];
  const std::vector<double>& t = (*at.trajectory)[Channel::t];
  const Rule rule = gauss(at.dt_s);
  Reader reader(at, faults);

  // e at the nodes, one after the other; the integral goes along from sample to sample.
  Vec2<double> integral = Vec2<double>::Zero(), before = Vec2<double>::Zero();
  std::size_t sample = at.nodes[segment.first_node].begin;
  for (std::size_t j = 0; j <= segment.count; ++j) {
    const Node& node = at.nodes[segment.first_node + j];
    Vec2<double> sum = Vec2<double>::Zero();
    double count = 0.0, reference = 0.0;
    for (std::size_t k = node.begin; k < node.end; ++k) {
      for (; sample < k; ++sample) {
        const double h = t[sample + 1] - t[sample];
        for (std::size_t q = 0; q < rule.points; ++q)
          integral += h * rule.weight[q] * reader.rate(kind, t[sample] + h * rule.at[q]);
      }
      if (!is_finite_at(*at.trajectory, k, kind)) continue;
      Vec2<double> e;
      if (kind == Kinematics::track) {
        e = reader.position(k);
      } else {
        // Headings of one node differ by little: a jump of a whole turn is one of counting.
        double psi = (*at.trajectory)[Channel::psi][k];
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

}  // namespace leeway::gap
