#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "gap/sensors/sensor_faults.hpp"
#include "gap/sensors/spline.hpp"

namespace leeway::gap {

/// Which part of the kinematics a row of residuals is of.
enum class Kinematics : std::size_t {
  track,   ///< x0 or y0 [m]: what eta moved over a window, less the integral of R(psi) nu
  heading  ///< [rad]: what psi turned over a window, less the integral of r
};

/// Rows of one kind that follow one another without a gap: windows side by side.
struct WindowRun {
  Kinematics kind = Kinematics::track;
  std::size_t unit = 0;  ///< recording or block of a recording, the unit of resampling
  Eigen::Index begin = 0, size = 0;
  bool is_first_of_unit = false, is_last_of_unit = false;
};

/// The residuals of recordings against their own kinematics, as a function of the sensors' faults.
///
/// With e(t) = eta(t) - integral of R(psi) nu from the start to t, the residual of a window is the mean of e about its
/// end less that about its start, the means over 1/10 of the window (a single sample where it is sampled slowly).
/// Channels are read between samples by cubic splines, integrals by Gauss's rule; latencies shift the time at which a
/// channel is read, so they are not rounded to samples. A window that touches a hole of more than three samples and 1 s
/// in a channel that it needs, with a margin of the longest latency, is left out.
class KinematicWindows {
 public:
  /// Of recordings in lengths and times of a ship of 3 m.
  explicit KinematicWindows(const std::vector<Trajectory>& recordings);

  /// All residuals under the given faults, run after run.
  Eigen::VectorXd residuals(const SensorFaults& faults) const;
  /// The same with the rows of the other kind left as they are in `residuals`.
  void update(Kinematics kind, const SensorFaults& faults, Eigen::VectorXd& residuals) const;

  const std::vector<WindowRun>& runs() const { return runs_; }
  Eigen::Index rows() const { return rows_; }
  std::size_t windows(Kinematics kind) const;
  std::size_t unit_count() const { return unit_recording_.size(); }
  std::size_t recording_of(std::size_t unit) const { return unit_recording_[unit]; }
  /// Whether units are whole recordings rather than blocks.
  bool units_are_recordings() const { return units_are_recordings_; }
  double longest_latency_s() const { return margin_s_; }
  double window_s() const { return window_s_; }
  double sample_s() const { return sample_s_; }
  double rms_speed() const { return rms_speed_; }
  double rms_rate() const { return rms_rate_; }
  double rms_turned() const;  ///< of the heading over the windows [rad]
  /// What the noise of r adds to its integral over a window [rad], from the second differences of its samples.
  double rate_noise() const { return rate_noise_; }

 private:
  struct Node {
    std::size_t begin = 0, end = 0;  ///< samples about its time
    double time_s = 0.0;
    std::size_t span = 0;  ///< between jumps of the clock
  };
  struct Recorded {
    const Trajectory* trajectory = nullptr;
    Spline u, v, r, psi;
    double dt_s = 0.0;
    std::vector<Node> nodes;
    std::array<std::vector<bool>, 2> is_valid;  ///< by kind, of the window from node j to node j + 1
    std::size_t first_unit = 0, units = 0, windows_per_unit = 0;
  };
  struct Segment {  ///< the runs of one recording, kind and stretch: the x rows, then, for a track, the y rows
    std::size_t recording = 0, first_node = 0, count = 0;
    Kinematics kind = Kinematics::track;
    Eigen::Index begin = 0;
  };

  class Reader;

  void measure(const std::vector<Trajectory>& recordings);
  Recorded read(const Trajectory& recording) const;
  std::vector<bool> whole_windows(const Recorded& at, Kinematics kind, const std::vector<const Spline*>& needed,
                                  bool is_there) const;
  void add_segments(std::size_t recording, Kinematics kind);
  void update(const Segment& segment, const SensorFaults& faults, Eigen::VectorXd& residuals) const;

  std::vector<Recorded> recorded_;
  std::vector<Segment> segments_;
  std::vector<WindowRun> runs_;
  std::vector<std::size_t> unit_recording_;
  Eigen::Index rows_ = 0;
  bool units_are_recordings_ = false;
  double margin_s_ = 0.0, window_s_ = 0.0, sample_s_ = 0.0, rms_speed_ = 0.0, rms_rate_ = 0.0, rate_noise_ = 0.0;
};

}  // namespace leeway::gap
