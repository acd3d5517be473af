#pragma once

#include <optional>
#include <vector>

#include "core/types.hpp"
#include "recording/trajectory.hpp"

namespace leeway {

/// A complete trajectory between its samples: pose by cubic Hermite polynomials, whose slopes are the recorded
/// velocities (fourth order in the sampling time), velocities linear. The trajectory must outlive it.
class Track {
 public:
  struct Moment {
    double t_s;
    Vec2<double> position;  ///< earth axes [m]
    double psi;             ///< [rad]
    Vec3<double> nu;        ///< (u, v_m [m/s], r [rad/s])
    Vec2<double> velocity;  ///< over ground, earth axes [m/s]
    double speed() const { return velocity.norm(); }
  };

  /// Needs at least one sample, and every state in each.
  explicit Track(const Trajectory& trajectory);

  double start_s() const { return t_.front(); }
  double end_s() const { return t_.back(); }
  const std::vector<double>& times() const { return t_; }
  /// The state at a time within the run, or at its nearer end.
  Moment at(double t_s) const;
  /// Length of the track over ground from the start [m].
  double length(double t_s) const;
  /// Mean over a part of the run, trapezoidal; f(moment) is sampled at the recorded times and at both ends.
  template <typename F>
  double mean(double from_s, double to_s, F f) const {
    double sum = 0.0, last_t = from_s, last = f(at(from_s));
    for (std::size_t i = first_after(from_s); last_t < to_s; ++i) {
      const double t = i < t_.size() && t_[i] < to_s ? t_[i] : to_s, value = f(at(t));
      sum += 0.5 * (last + value) * (t - last_t);
      last_t = t;
      last = value;
    }
    return sum / (to_s - from_s);
  }
  /// The first time from `from_s` on at which f(moment) rises from below 0 to 0 or above, to rounding; nothing where it
  /// does not. f is looked at in the recorded times.
  template <typename F>
  std::optional<double> first_rise(double from_s, F f) const {
    double low = from_s;
    bool is_below = f(at(low)) < 0.0;
    for (std::size_t i = first_after(from_s); i < t_.size(); ++i) {
      const bool was_below = is_below;
      is_below = f(at(t_[i])) < 0.0;
      if (!was_below || is_below) {
        low = t_[i];
        continue;
      }
      double high = t_[i];
      for (int bisection = 0; bisection < 60; ++bisection) {
        const double middle = 0.5 * (low + high);
        (f(at(middle)) < 0.0 ? low : high) = middle;
      }
      return high;
    }
    return std::nullopt;
  }

 private:
  std::size_t first_after(double t_s) const;  // index of the first sample later than t_s

  const Trajectory& trajectory_;
  const std::vector<double>& t_;
  std::vector<double> length_;
};

}  // namespace leeway
