#include "foreign/motion_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/units.hpp"
#include "recording/trajectory.hpp"

namespace leeway::foreign {
namespace {

constexpr std::size_t kWindows = 60, kFewestSamples = 4;

// The units that a column may have: the one that is known, or all.
std::vector<Reading> readings(Quantity quantity, const std::string& unit) {
  std::vector<Reading> all;
  for (const std::string_view suffix : io::units_of(quantity))
    if (unit.empty() || unit == suffix) all.push_back({std::string(suffix), io::unit_of(quantity, suffix)->factor});
  return all;
}

std::vector<Reading> both_signs(std::vector<Reading> all) {
  const std::size_t n = all.size();
  for (std::size_t i = 0; i < n; ++i) all.push_back({all[i].unit, -all[i].factor});
  return all;
}

// sqrt(sum of a^2 / sum of b^2), where both are known.
double ratio(const std::vector<double>& a, const std::vector<double>& b) {
  double above = 0.0, below = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i]) || std::isnan(b[i])) continue;
    above += a[i] * a[i];
    below += b[i] * b[i];
  }
  return below > 0.0 ? std::sqrt(above / below) : 1.0;
}

double wrapped(double angle) { return std::remainder(angle, 2.0 * kPi); }

struct EarthVelocity {
  std::vector<double> north, east;
};

// Velocities along x0 and y0 by factors of the two columns.
EarthVelocity earth_velocity(io::VelocityFrame frame, const MotionColumns& c, const std::vector<double>& heading,
                             double u_factor, double vm_factor) {
  EarthVelocity v{std::vector<double>(c.u.size()), std::vector<double>(c.u.size())};
  for (std::size_t i = 0; i < c.u.size(); ++i) {
    const double u = u_factor * c.u[i], vm = vm_factor * c.vm[i];
    if (frame == io::VelocityFrame::earth) {
      v.north[i] = u;
      v.east[i] = vm;
    } else {
      const double angle = frame == io::VelocityFrame::ship ? heading[i] : vm;
      const double across = frame == io::VelocityFrame::ship ? vm : 0.0;
      v.north[i] = u * std::cos(angle) - across * std::sin(angle);
      v.east[i] = u * std::sin(angle) + across * std::cos(angle);
    }
  }
  return v;
}

double motion_misfit(const Windows& windows, const MotionColumns& c, const EarthVelocity& v) {
  std::vector<double> difference, increments;
  for (std::size_t w = 0; w < windows.size(); ++w)
    for (const auto& [position, velocity] :
         {std::pair{c.x0, std::span<const double>(v.north)}, std::pair{c.y0, std::span<const double>(v.east)}}) {
      increments.push_back(windows.increment(w, position));
      difference.push_back(increments.back() - windows.integral(w, velocity));
    }
  return ratio(difference, increments);
}

}  // namespace

Windows::Windows(std::vector<double> t) : t_(std::move(t)) {
  if (t_.size() < 2 * kFewestSamples) return;
  const std::size_t length = std::max(kFewestSamples, t_.size() / kWindows);
  for (std::size_t i = 0; i + length < t_.size(); i += std::max<std::size_t>(1, length / 2)) {
    first_.push_back(i);
    last_.push_back(i + length);
  }
}

double Windows::increment(std::size_t window, std::span<const double> values) const {
  return values[last_[window]] - values[first_[window]];
}

double Windows::integral(std::size_t window, std::span<const double> values) const {
  double sum = 0.0;
  for (std::size_t i = first_[window]; i < last_[window]; ++i)
    sum += 0.5 * (values[i] + values[i + 1]) * (t_[i + 1] - t_[i]);
  return sum;
}

std::vector<double> heading_in_rad(std::span<const double> psi, const Reading& reading) {
  std::vector<double> heading(psi.begin(), psi.end());
  for (double& angle : heading) angle *= reading.factor;
  unwrap(heading);
  return heading;
}

YawFit fit_yaw(const Windows& windows, std::span<const double> psi, const std::string& psi_unit,
               std::span<const double> r, const std::string& r_unit) {
  YawFit best;
  for (const Reading& psi_reading : readings(Quantity::angle, psi_unit)) {
    const std::vector<double> heading = heading_in_rad(psi, psi_reading);
    for (const Reading& r_reading : both_signs(readings(Quantity::angular_rate, r_unit))) {
      std::vector<double> difference, increments;
      for (std::size_t w = 0; w < windows.size(); ++w) {
        increments.push_back(windows.increment(w, heading));
        difference.push_back(increments.back() - r_reading.factor * windows.integral(w, r));
      }
      if (const double misfit = ratio(difference, increments); misfit < best.misfit)
        best = {psi_reading, r_reading, misfit};
    }
  }
  return best;
}

MotionFit fit_motion(const Windows& windows, const MotionColumns& c) {
  std::array<MotionFit, 3> best;  // by frame
  for (const Reading& psi : both_signs(readings(Quantity::angle, c.psi_unit))) {
    const std::vector<double> heading = heading_in_rad(c.psi, psi);
    for (const io::VelocityFrame frame : c.frames) {
      const bool is_course = frame == io::VelocityFrame::course_and_speed;
      if (frame == io::VelocityFrame::earth && (psi.factor < 0.0)) continue;  // the heading plays no part
      for (const Reading& u : both_signs(readings(Quantity::speed, c.u_unit)))
        for (const Reading& vm : both_signs(readings(is_course ? Quantity::angle : Quantity::speed, c.vm_unit))) {
          if (!is_course && vm.unit != u.unit && c.u_unit.empty() && c.vm_unit.empty()) continue;
          if (is_course && u.factor < 0.0) continue;
          const double misfit = motion_misfit(windows, c, earth_velocity(frame, c, heading, u.factor, vm.factor));
          MotionFit& fit = best[static_cast<std::size_t>(frame)];
          if (misfit < fit.misfit) fit = {frame, psi, u, vm, misfit, std::nullopt, heading};
        }
    }
  }
  std::sort(best.begin(), best.end(), [](const MotionFit& a, const MotionFit& b) { return a.misfit < b.misfit; });
  if (best[1].misfit < 1.0) best[0].other_frame = best[1].misfit;
  // Frames that do not show the heading's sign and unit leave them to the direction of the track.
  if (best[0].frame != io::VelocityFrame::ship && best[0].misfit < 1.0) {
    best[0].psi = fit_direction(windows, c.x0, c.y0, c.psi, c.psi_unit).psi;
    best[0].heading = heading_in_rad(c.psi, best[0].psi);
  }
  return best[0];
}

DirectionFit fit_direction(const Windows& windows, std::span<const double> x0, std::span<const double> y0,
                           std::span<const double> psi, const std::string& psi_unit) {
  DirectionFit best;
  for (const Reading& reading : both_signs(readings(Quantity::angle, psi_unit))) {
    const std::vector<double> heading = heading_in_rad(psi, reading);
    double squares = 0.0, mean = 0.0, count = 0.0;
    std::vector<double> angles;
    for (std::size_t w = 0; w < windows.size(); ++w) {
      const double dx = windows.increment(w, x0), dy = windows.increment(w, y0);
      const double angle = windows.integral(w, heading) / windows.length_s(w);
      if (std::isnan(dx + dy + angle) || (dx == 0.0 && dy == 0.0)) continue;
      squares += std::pow(wrapped(std::atan2(dy, dx) - angle), 2);
      angles.push_back(angle);
      mean += angle;
      count += 1.0;
    }
    double scatter = 0.0;
    for (const double angle : angles) scatter += std::pow(angle - mean / count, 2);
    // Headings that scatter over turns tell nothing where they are no headings.
    scatter = std::min(scatter, count * kPi * kPi / 3.0);
    if (scatter > 0.0 && std::sqrt(squares / scatter) < best.misfit) best = {reading, std::sqrt(squares / scatter)};
  }
  return best;
}

}  // namespace leeway::foreign
