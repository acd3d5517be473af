#include "gap/correct/sensing.hpp"

#include <array>
#include <cmath>

#include "gap/sensors/spline.hpp"

namespace leeway::gap {
namespace {

using enum FaultParameter;

// One channel along the path, also between its points and before them.
class Course {
 public:
  Course(const std::vector<double>& t_s, const std::vector<double>& x)
      : begin_s_(t_s.front()), first_(x.front()), spline_(t_s, x) {
    if (t_s.size() > 1) slope_ = (x[1] - x[0]) / (t_s[1] - t_s[0]);
  }
  double slope() const { return slope_; }
  double at(double t_s) { return t_s < begin_s_ ? first_ + (t_s - begin_s_) * slope_ : spline_.value(t_s, place_); }

 private:
  double begin_s_, first_, slope_ = 0.0;
  Spline spline_;
  std::size_t place_ = 0;
};

// Behind a lag of first order, exactly where the channel is straight from point to point and before the first.
std::vector<double> lagged(const std::vector<double>& t_s, const std::vector<double>& x, double lag_s) {
  std::vector<double> result{x.front() - lag_s * Course(t_s, x).slope()};
  for (std::size_t k = 1; k < t_s.size(); ++k) {
    const double h = t_s[k] - t_s[k - 1], kept = std::exp(-h / lag_s), slope = (x[k] - x[k - 1]) / h;
    result.push_back(kept * result.back() + (1.0 - kept) * x[k - 1] + (h - lag_s * (1.0 - kept)) * slope);
  }
  return result;
}

}  // namespace

std::vector<Vec6> read_beside(const SensorFaults& faults, const std::vector<double>& t_s,
                              const std::vector<StateVector>& path) {
  const std::size_t n = path.size();
  std::array<std::vector<double>, kShipStates> read;
  for (const StateVector& x : path) {
    const double c = std::cos(x[2]), s = std::sin(x[2]);
    const double current_u = c * faults[current_x] + s * faults[current_y],
                 current_v = -s * faults[current_x] + c * faults[current_y];
    const std::array<double, kShipStates> at{
        x[0] + c * faults[lever_x] - s * faults[lever_y],
        x[1] + s * faults[lever_x] + c * faults[lever_y],
        x[2] + faults[heading_bias],
        (1.0 + faults[log_scale]) * (x[3] - current_u) + faults[log_bias_u],
        (1.0 + faults[sway_log_scale]) * (x[4] - current_v) + faults[log_bias_v],
        (1.0 + faults[rate_scale]) * x[5] + faults[rate_bias],
    };
    for (std::size_t i = 0; i < at.size(); ++i) read[i].push_back(at[i]);
  }
  const std::array<double, kShipStates> lag{
      0.0, 0.0, faults[heading_filter], faults[velocity_filter], faults[velocity_filter], faults[rate_filter]};
  const std::array<double, kShipStates> latency{faults[position_latency], faults[position_latency],
                                                faults[heading_latency],  faults[velocity_latency],
                                                faults[velocity_latency], faults[rate_latency]};
  for (std::size_t i = 0; i < read.size(); ++i) {
    if (lag[i] > 0.0) read[i] = lagged(t_s, read[i], lag[i]);
    if (latency[i] == 0.0) continue;
    Course course(t_s, read[i]);
    for (std::size_t k = 0; k < n; ++k) read[i][k] = course.at(t_s[k] - latency[i]);
  }
  std::vector<Vec6> result(n);
  for (std::size_t k = 0; k < n; ++k)
    for (int i = 0; i < kShipStates; ++i) result[k][i] = read[static_cast<std::size_t>(i)][k] - path[k][i];
  return result;
}

}  // namespace leeway::gap
