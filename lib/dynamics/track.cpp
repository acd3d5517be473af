#include "dynamics/track.hpp"

#include <algorithm>
#include <cmath>

namespace leeway {
namespace {

Track::Moment sample(const Trajectory& t, std::size_t i) {
  const double psi = t[Channel::psi][i], u = t[Channel::u][i], v_m = t[Channel::vm][i];
  const double c = std::cos(psi), s = std::sin(psi);
  return {t[Channel::t][i],
          {t[Channel::x0][i], t[Channel::y0][i]},
          psi,
          {u, v_m, t[Channel::r][i]},
          {u * c - v_m * s, u * s + v_m * c}};
}

// Cubic Hermite interpolation at the part x of a step h, with the slopes da and db.
template <typename V>
V hermite(const V& a, const V& da, const V& b, const V& db, double x, double h) {
  const double x2 = x * x, x3 = x2 * x;
  return (2.0 * x3 - 3.0 * x2 + 1.0) * a + (x3 - 2.0 * x2 + x) * h * da + (3.0 * x2 - 2.0 * x3) * b +
         (x3 - x2) * h * db;
}

}  // namespace

Track::Track(const Trajectory& trajectory) : trajectory_(trajectory), t_(trajectory[Channel::t]) {
  length_.push_back(0.0);
  for (std::size_t i = 1; i < t_.size(); ++i)
    length_.push_back(length_.back() +
                      0.5 * (sample(trajectory, i - 1).speed() + sample(trajectory, i).speed()) * (t_[i] - t_[i - 1]));
}

std::size_t Track::first_after(double t_s) const {
  return static_cast<std::size_t>(std::upper_bound(t_.begin(), t_.end(), t_s) - t_.begin());
}

Track::Moment Track::at(double t_s) const {
  const std::size_t after = first_after(t_s);
  if (after == 0) return sample(trajectory_, 0);
  const Moment a = sample(trajectory_, after - 1);
  if (after == t_.size() || a.t_s == t_s) return sample(trajectory_, after - 1);
  const Moment b = sample(trajectory_, after);
  const double h = b.t_s - a.t_s, x = (t_s - a.t_s) / h;
  Moment m{t_s, hermite(a.position, a.velocity, b.position, b.velocity, x, h),
           hermite(a.psi, a.nu(2), b.psi, b.nu(2), x, h), a.nu + x * (b.nu - a.nu), Vec2<double>::Zero()};
  const double c = std::cos(m.psi), s = std::sin(m.psi);
  m.velocity = {m.nu(0) * c - m.nu(1) * s, m.nu(0) * s + m.nu(1) * c};
  return m;
}

double Track::length(double t_s) const {
  const std::size_t after = first_after(t_s);
  if (after == 0) return 0.0;
  const double before_s = t_[after - 1];
  if (after == t_.size()) return length_.back();
  return length_[after - 1] + 0.5 * (at(before_s).speed() + at(t_s).speed()) * (t_s - before_s);
}

}  // namespace leeway
