#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/columns_map.hpp"

namespace leeway::foreign {

inline constexpr double kFits = 0.3;  ///< relative misfit up to which the kinematics decide

/// Windows of a recording over which increments of positions and headings are compared with integrals of velocities, so
/// that noise and rounding matter little.
class Windows {
 public:
  ///   t  [s], increasing
  explicit Windows(std::vector<double> t);

  std::size_t size() const { return first_.size(); }
  double length_s(std::size_t window) const { return t_[last_[window]] - t_[first_[window]]; }
  /// NaN where a sample is missing.
  double increment(std::size_t window, std::span<const double> values) const;
  double integral(std::size_t window, std::span<const double> values) const;

 private:
  std::vector<double> t_;
  std::vector<std::size_t> first_, last_;
};

/// A unit of a column, and whether its sign is turned.
struct Reading {
  std::string unit;
  double factor = 1.0;  ///< to SI, with the sign
};

/// How heading and yaw rate fit: psi' = r.
struct YawFit {
  Reading psi, r;
  double misfit = 1.0;  ///< rms of the difference by that of the heading's increments
};
/// The best of all units that are not known ("": not known); the heading's sign is taken as it is.
YawFit fit_yaw(const Windows& windows, std::span<const double> psi, const std::string& psi_unit,
               std::span<const double> r, const std::string& r_unit);

/// How positions, heading and velocities fit: (x0', y0') = R(psi) (u, v_m), or as the frame says. y0 keeps its sign.
struct MotionFit {
  io::VelocityFrame frame = io::VelocityFrame::ship;
  Reading psi, u, vm;
  double misfit = 1.0;                ///< rms of the difference by that of the positions' increments
  std::optional<double> other_frame;  ///< the best misfit of another frame
  std::vector<double> heading;        ///< [rad], unwrapped
};
struct MotionColumns {
  std::span<const double> x0, y0;  ///< [m]
  std::span<const double> psi, u, vm;
  std::string psi_unit, u_unit, vm_unit;  ///< "": not known
  std::vector<io::VelocityFrame> frames;  ///< to choose among
};
MotionFit fit_motion(const Windows& windows, const MotionColumns& columns);

/// How well the direction of the track follows a heading: rms of their difference by the heading's own scatter.
struct DirectionFit {
  Reading psi;
  double misfit = 1e9;
};
DirectionFit fit_direction(const Windows& windows, std::span<const double> x0, std::span<const double> y0,
                           std::span<const double> psi, const std::string& psi_unit);

/// Unwrapped where it jumps by a turn in this unit, in radians.
std::vector<double> heading_in_rad(std::span<const double> psi, const Reading& reading);

}  // namespace leeway::foreign
