#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/types.hpp"
#include "recording/trajectory.hpp"

namespace leeway {

/// Variance of the share of every change by which an input is ahead of, or behind, the straight line between samples:
/// uniform in +-1/2.
constexpr double kInputShareVariance = 1.0 / 12.0;

/// A stretch of a recording without gaps on an equidistant time grid; column k belongs to t_s(k).
struct Samples {
  std::string recording;  ///< name of the trajectory
  std::string file;       ///< for messages
  double t0_s = 0.0, dt_s = 0.0;
  bool has_position = false, has_heading = false;
  Eigen::Matrix3Xd eta;        ///< (x0 [m], y0 [m], psi [rad]) at t(k), zero where the recording has none
  Eigen::Matrix3Xd nu;         ///< (u, v_m [m/s], r [rad/s]) at t(k)
  Eigen::MatrixXd actuators;   ///< one row per requested channel, what acts from t(k) to t(k+1)
  Eigen::Matrix2Xd true_wind;  ///< from-vector in earth axes [m/s], from t(k) to t(k+1); zero where not requested
  /// What their path between samples leaves open of these means: the changes from sample to sample, each by its part of
  /// the step. Were the inputs further on by a share of every change, the means would be so by that share of this.
  Eigen::MatrixXd actuators_open;
  Eigen::Matrix2Xd true_wind_open;

  Eigen::Index size() const { return nu.cols(); }
  double t_s(Eigen::Index k) const { return t0_s + static_cast<double>(k) * dt_s; }
};

enum class StateResampling {
  decimate,  ///< the state at t(k), linear between the two samples around it
  average    ///< the mean of the samples within half a step of t(k)
};

enum class InputPath {
  held,   ///< an input keeps a sample's value until the next sample comes
  linear  ///< it goes straight from sample to sample
};

/// Puts a recording on the grid t(k) = first time + k dt_s, and splits it where samples are missing.
///
/// States are taken as `resampling` says. Actuators and wind are means over [t(k), t(k+1)), so that a zero-order hold
/// keeps their effect, of samples or of the lines between them as `inputs` says; the mean of wind is that of its
/// vector. An apparent wind alone is turned into the true wind with the recorded heading and velocity. A hole of at
/// most 1.5 steps (of the grid or of the recording, whichever is longer) is bridged: states linearly, inputs by
/// holding; a longer one ends the stretch, and costs nothing however long it is. Stretches shorter than two points are
/// left out.
///   actuators  channels to sample; a missing one is an InputError
std::vector<Samples> resample(const Trajectory& trajectory, std::span<const Channel> actuators, bool with_wind,
                              double dt_s, StateResampling resampling = StateResampling::decimate,
                              InputPath inputs = InputPath::held);

/// A run of points of one Samples.
struct Range {
  Eigen::Index begin = 0, size = 0;
};

/// Training windows: K points each, side by side; the last one is moved back to end with the data and so overlaps its
/// neighbor. Fewer than K points make one window of their own length. Every point is in a window.
std::vector<Range> training_windows(Eigen::Index points, Eigen::Index K);

/// Test sequences: K points each, side by side, never overlapping; a rest shorter than K is in none.
std::vector<Range> test_sequences(Eigen::Index points, Eigen::Index K);

}  // namespace leeway
