#include "recording/samples.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/errors.hpp"
#include "core/wind.hpp"

namespace leeway {
namespace {

constexpr double kSameTime = 1e-6;    // of a step: below it, a grid time and a sample time are the same
constexpr double kLongestHole = 1.5;  // steps
constexpr double kMostGridSteps =
    1000.0;  // of the grid between two samples, our choice: beyond it t_s is not in seconds

// A run of the times t(k) = first time + k dt, from k = first on.
struct Grid {
  const std::vector<double>& t;
  double dt_s, longest_hole_s;
  double first;  // whole
  std::size_t points;
  double at(std::size_t k) const { return t.front() + (first + static_cast<double>(k)) * dt_s; }
  // First sample that is not before `time` (within rounding).
  std::size_t first_from(double time) const {
    return static_cast<std::size_t>(std::lower_bound(t.begin(), t.end(), time - kSameTime * dt_s) - t.begin());
  }
};

// The runs of grid times at which a state can be known: not those within holes, however long these are. Runs that touch
// are one.
std::vector<Grid> grids_between_holes(const std::vector<double>& t, double dt_s, double longest_hole_s) {
  const auto number = [&](double time) { return std::floor((time - t.front()) / dt_s + kSameTime); };
  struct Run {
    double first, last;
  };
  std::vector<Run> runs;
  const double last_of_all = number(t.back());
  for (std::size_t begin = 0; begin < t.size();) {
    std::size_t end = begin + 1;
    while (end < t.size() && t[end] - t[end - 1] <= longest_hole_s) ++end;
    const double first = std::max(0.0, number(t[begin]) - 1.0);
    const double last = std::min(last_of_all, number(t[end - 1]) + 2.0);
    if (!runs.empty() && first <= runs.back().last + 1.0)
      runs.back().last = std::max(runs.back().last, last);
    else
      runs.push_back({first, last});
    begin = end;
  }
  std::vector<Grid> grids;
  for (const Run& run : runs)
    grids.push_back({t, dt_s, longest_hole_s, run.first, static_cast<std::size_t>(run.last - run.first) + 1});
  return grids;
}

// The value at each grid time, linear between the finite samples around it; NaN in a hole.
std::vector<double> at_grid_times(const Grid& grid, const std::vector<double>& values) {
  std::vector<double> result(grid.points, kMissing);
  for (std::size_t k = 0; k < grid.points; ++k) {
    const double time = grid.at(k);
    std::size_t after = grid.first_from(time);
    while (after < values.size() && std::isnan(values[after]) && grid.t[after] - time <= grid.longest_hole_s) ++after;
    if (after < values.size() && std::abs(grid.t[after] - time) <= kSameTime * grid.dt_s) {
      result[k] = values[after];
      continue;
    }
    std::size_t before = grid.first_from(time);
    while (before > 0 && std::isnan(values[before - 1]) && time - grid.t[before - 1] <= grid.longest_hole_s) --before;
    if (before == 0 || after == values.size()) continue;
    const double t0 = grid.t[before - 1], t1 = grid.t[after];
    if (t1 - t0 > grid.longest_hole_s) continue;
    result[k] = values[before - 1] + (values[after] - values[before - 1]) * (time - t0) / (t1 - t0);
  }
  return result;
}

enum class End { excluded, included };

// The mean of the finite samples from t(k) + from to t(k) + to; where there is none, NaN.
std::vector<double> means(const Grid& grid, const std::vector<double>& values, double from_s, double to_s, End last) {
  std::vector<double> result(grid.points, kMissing);
  for (std::size_t k = 0; k < grid.points; ++k) {
    const std::size_t begin = grid.first_from(grid.at(k) + from_s);
    std::size_t end = grid.first_from(grid.at(k) + to_s);
    if (last == End::included && end < values.size() && grid.t[end] - grid.at(k) - to_s <= kSameTime * grid.dt_s) ++end;
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t i = begin; i < end; ++i)
      if (!std::isnan(values[i])) {
        sum += values[i];
        ++count;
      }
    if (count > 0) result[k] = sum / static_cast<double>(count);
  }
  return result;
}

// Inputs act until the next sample comes: a value is held over a hole that is not too long.
std::vector<double> held_means(const Grid& grid, const std::vector<double>& values) {
  std::vector<double> result = means(grid, values, 0.0, grid.dt_s, End::excluded);
  for (std::size_t k = 0; k < grid.points; ++k) {
    if (!std::isnan(result[k])) continue;
    const double time = grid.at(k);
    std::size_t before = grid.first_from(time);
    while (before > 0 && std::isnan(values[before - 1]) && time - grid.t[before - 1] <= grid.longest_hole_s) --before;
    if (before > 0 && time - grid.t[before - 1] <= grid.longest_hole_s) result[k] = values[before - 1];
  }
  return result;
}

// Means over each step, and what they leave open: see Samples.
struct InputMeans {
  std::vector<double> mean, open;
};

// Where a hole or the end cuts off the path, held means.
InputMeans input_means(const Grid& grid, const std::vector<double>& values, InputPath path) {
  InputMeans result{held_means(grid, values), std::vector<double>(grid.points, 0.0)};
  const std::vector<double> ends = at_grid_times(grid, values);
  for (std::size_t k = 0; k + 1 < grid.points; ++k) {
    double time = grid.at(k), value = ends[k], integral = 0.0, open = 0.0;
    const double end = grid.at(k + 1);
    const auto go_to = [&](double next_time, double next) {
      const double part = (next_time - time) / grid.dt_s, change = next - value;
      integral += part * (value + 0.5 * change);
      open += part * change;
      time = next_time;
      value = next;
    };
    for (std::size_t i = grid.first_from(time); i < values.size() && grid.t[i] < end - kSameTime * grid.dt_s; ++i)
      if (!std::isnan(values[i]) && grid.t[i] > time) go_to(grid.t[i], values[i]);
    go_to(end, ends[k + 1]);
    if (std::isnan(integral)) continue;
    if (path == InputPath::linear) result.mean[k] = integral;
    result.open[k] = open;
  }
  return result;
}

// The true wind of each raw sample as from-vector in earth axes: x and y.
std::vector<std::vector<double>> raw_true_wind(const Trajectory& trajectory) {
  const std::size_t n = trajectory.size();
  std::vector<std::vector<double>> wind(2, std::vector<double>(n));
  const bool is_true = trajectory.has(Channel::wind_speed) && trajectory.has(Channel::wind_dir);
  for (std::size_t i = 0; i < n; ++i) {
    Vec2<double> w;
    if (is_true) {
      w = wind_from_vector(trajectory[Channel::wind_speed][i], trajectory[Channel::wind_dir][i]);
    } else {
      const Vec2<double> apparent =
          wind_from_vector(trajectory[Channel::app_wind_speed][i], trajectory[Channel::app_wind_dir][i]);
      w = true_wind_from_apparent(apparent, trajectory[Channel::psi][i], trajectory[Channel::u][i],
                                  trajectory[Channel::vm][i]);
    }
    wind[0][i] = w(0);
    wind[1][i] = w(1);
  }
  return wind;
}

// Rows of numbers at the grid times, in this order: u, v_m, r, psi, x0, y0, actuators, true wind x and y.
struct Rows {
  std::vector<std::vector<double>> values;
  std::vector<std::vector<double>> open;  // of actuators and wind
  bool has_heading = false, has_position = false, has_wind = false;
  std::size_t first_actuator = 0, actuators = 0;

  bool complete(std::size_t k) const {
    return std::none_of(values.begin(), values.end(), [k](const auto& row) { return std::isnan(row[k]); });
  }
};

Rows rows_of(const Trajectory& trajectory, std::span<const Channel> actuators,
             const std::vector<std::vector<double>>& wind, const Grid& grid, StateResampling resampling,
             InputPath path) {
  const auto state = [&](Channel channel) {
    const std::vector<double>& values = trajectory[channel];
    std::vector<double> result = at_grid_times(grid, values);
    if (resampling == StateResampling::decimate) return result;
    // Both ends count, so that the mean belongs to t(k); a short hole is bridged as it is without averaging.
    const std::vector<double> averaged = means(grid, values, -0.5 * grid.dt_s, 0.5 * grid.dt_s, End::included);
    for (std::size_t k = 0; k < result.size(); ++k)
      if (!std::isnan(averaged[k])) result[k] = averaged[k];
    return result;
  };
  Rows rows;
  for (const Channel channel : {Channel::u, Channel::vm, Channel::r}) rows.values.push_back(state(channel));
  rows.has_heading = trajectory.has(Channel::psi);
  rows.has_position = rows.has_heading && trajectory.has(Channel::x0) && trajectory.has(Channel::y0);
  if (rows.has_heading) rows.values.push_back(state(Channel::psi));
  if (rows.has_position) {
    rows.values.push_back(state(Channel::x0));
    rows.values.push_back(state(Channel::y0));
  }
  rows.first_actuator = rows.values.size();
  rows.actuators = actuators.size();
  rows.has_wind = !wind.empty();
  const auto add_input = [&](const std::vector<double>& values) {
    InputMeans means = input_means(grid, values, path);
    rows.values.push_back(std::move(means.mean));
    rows.open.push_back(std::move(means.open));
  };
  for (const Channel channel : actuators) add_input(trajectory[channel]);
  for (const std::vector<double>& component : wind) add_input(component);
  return rows;
}

// The grid times from begin to end.
Samples samples_of(const Trajectory& trajectory, const Grid& grid, const Rows& rows, std::size_t begin,
                   std::size_t end) {
  const auto n = static_cast<Eigen::Index>(end - begin);
  const auto row = [&](std::size_t i) {
    return Eigen::Map<const Eigen::RowVectorXd>(rows.values[i].data() + begin, n);
  };
  const auto open = [&](std::size_t i) { return Eigen::Map<const Eigen::RowVectorXd>(rows.open[i].data() + begin, n); };
  Samples s;
  s.recording = trajectory.name;
  s.file = trajectory.file;
  s.t0_s = grid.at(begin);
  s.dt_s = grid.dt_s;
  s.has_position = rows.has_position;
  s.has_heading = rows.has_heading;
  s.eta = Eigen::Matrix3Xd::Zero(3, n);
  s.nu.resize(3, n);
  for (int i = 0; i < 3; ++i) s.nu.row(i) = row(i);
  if (rows.has_heading) s.eta.row(2) = row(3);
  if (rows.has_position) {
    s.eta.row(0) = row(4);
    s.eta.row(1) = row(5);
  }
  s.actuators.resize(static_cast<Eigen::Index>(rows.actuators), n);
  s.actuators_open.resize(static_cast<Eigen::Index>(rows.actuators), n);
  for (std::size_t a = 0; a < rows.actuators; ++a) {
    s.actuators.row(static_cast<Eigen::Index>(a)) = row(rows.first_actuator + a);
    s.actuators_open.row(static_cast<Eigen::Index>(a)) = open(a);
  }
  s.true_wind = s.true_wind_open = Eigen::Matrix2Xd::Zero(2, n);
  if (rows.has_wind)
    for (int i = 0; i < 2; ++i) {
      s.true_wind.row(i) = row(rows.first_actuator + rows.actuators + i);
      s.true_wind_open.row(i) = open(rows.actuators + i);
    }
  return s;
}

}  // namespace

std::vector<Samples> resample(const Trajectory& trajectory, std::span<const Channel> actuators, bool with_wind,
                              double dt_s, StateResampling resampling, InputPath inputs) {
  const auto require = [&](Channel channel) -> const std::vector<double>& {
    if (!trajectory.has(channel))
      throw InputError(trajectory.file, 1, "", "no column '" + column_name(channel) + "', which is needed here");
    return trajectory[channel];
  };
  if (with_wind && !trajectory.has_wind())
    throw InputError(trajectory.file, 1, "",
                     "no wind: expected the columns wind_speed_mps and wind_dir_deg, or app_wind_speed_mps and "
                     "app_wind_dir_deg");
  if (with_wind) require(Channel::psi);
  for (const Channel channel : {Channel::u, Channel::vm, Channel::r}) require(channel);
  for (const Channel channel : actuators) require(channel);

  const std::vector<double>& t = trajectory[Channel::t];
  if (t.size() < 2) return {};
  const double sample_s = sampling_time_s(trajectory);
  if (sample_s > kMostGridSteps * dt_s)
    throw InputError(
        trajectory.file, 1, "column 't_s'",
        fmt::format("sampled every {:.6g} s; expected at most {} time steps of {} s between two samples: is "
                    "it in seconds?",
                    sample_s, kMostGridSteps, dt_s));
  const std::vector<std::vector<double>> wind =
      with_wind ? raw_true_wind(trajectory) : std::vector<std::vector<double>>();
  std::vector<Samples> stretches;
  for (const Grid& grid : grids_between_holes(t, dt_s, kLongestHole * std::max(dt_s, sample_s))) {
    const Rows rows = rows_of(trajectory, actuators, wind, grid, resampling, inputs);
    for (std::size_t begin = 0; begin < grid.points;) {
      std::size_t end = begin;
      while (end < grid.points && rows.complete(end)) ++end;
      if (end - begin >= 2) stretches.push_back(samples_of(trajectory, grid, rows, begin, end));
      begin = end + 1;
    }
  }
  return stretches;
}

std::vector<Range> training_windows(Eigen::Index points, Eigen::Index K) {
  if (points <= K) return points > 0 ? std::vector<Range>{{0, points}} : std::vector<Range>{};
  std::vector<Range> windows = test_sequences(points, K);
  if (windows.back().begin + K < points) windows.push_back({points - K, K});
  return windows;
}

std::vector<Range> test_sequences(Eigen::Index points, Eigen::Index K) {
  std::vector<Range> sequences;
  for (Eigen::Index begin = 0; begin + K <= points; begin += K) sequences.push_back({begin, K});
  return sequences;
}

}  // namespace leeway
