#include "dynamics/recorded_maneuver.hpp"

#include <algorithm>
#include <cmath>

#include "core/statistics.hpp"
#include "core/units.hpp"

namespace leeway {
namespace {

constexpr double kHeld = 0.5 * kDegree, kHeldShare = 0.04;  // how far a rudder that is held moves
constexpr double kLeastRudder = 3.0 * kDegree;
constexpr double kSameAmplitude = 0.3;  // relative difference of angles of one zigzag
constexpr double kLeastTurn = 0.05;     // heading change of a held angle by the largest one's
constexpr double kLeastTurning = 30.0 * kDegree;
constexpr double kWholeDegree = 0.35 * kDegree;
constexpr double kLateOrder = 0.25;  // of the time to 10 deg
constexpr double kSwitchingLag = 0.6 * kDegree;

// Samples over which the rudder is held.
struct Held {
  std::size_t first, last;
  double angle, turn;  // [rad]; change of heading over it
};

std::vector<double> rudder_of(const Trajectory& trajectory) {
  std::vector<double> sum;
  double count = 0.0;
  for (const Channel channel : {Channel::delta, Channel::delta_p, Channel::delta_s}) {
    const std::vector<double>& delta = trajectory[channel];
    if (delta.empty()) continue;
    sum.resize(delta.size());
    for (std::size_t i = 0; i < delta.size(); ++i) sum[i] += delta[i];
    count += 1.0;
  }
  for (double& delta : sum) delta /= count;
  return sum;
}

std::vector<Held> held_angles(const std::vector<double>& delta, const std::vector<double>& psi) {
  std::vector<Held> all;
  for (std::size_t i = 0; i < delta.size();) {
    double low = delta[i], high = delta[i];
    std::size_t last = i;
    while (last + 1 < delta.size()) {
      const double next = delta[last + 1];
      const double room = 2.0 * std::max(kHeld, kHeldShare * std::max(std::abs(low), std::abs(high)));
      if (std::max(high, next) - std::min(low, next) > room) break;
      low = std::min(low, next);
      high = std::max(high, next);
      ++last;
    }
    const double angle =
        median({delta.begin() + static_cast<std::ptrdiff_t>(i), delta.begin() + static_cast<std::ptrdiff_t>(last) + 1});
    if (last > i && std::abs(angle) >= kLeastRudder) all.push_back({i, last, angle, std::abs(psi[last] - psi[i])});
    i = last + 1;
  }
  return all;
}

// The held angles of one maneuver: around the one that turns the ship most, those that alternate with it.
std::vector<Held> chain(const std::vector<Held>& all, const std::vector<double>& t) {
  const auto main =
      std::max_element(all.begin(), all.end(), [](const Held& a, const Held& b) { return a.turn < b.turn; });
  std::vector<Held> kept;
  std::ptrdiff_t center = 0;
  for (auto held = all.begin(); held != all.end(); ++held) {
    const double ratio = std::abs(held->angle / main->angle);
    const bool is_like = ratio > 1.0 - kSameAmplitude && ratio < 1.0 + kSameAmplitude;
    if (!is_like || held->turn < kLeastTurn * main->turn) continue;
    if (held == main) center = static_cast<std::ptrdiff_t>(kept.size());
    kept.push_back(*held);
  }
  const auto follows = [&](const Held& a, const Held& b) {
    const double pause = t[b.first] - t[a.last], shorter = std::min(t[a.last] - t[a.first], t[b.last] - t[b.first]);
    return (a.angle > 0.0) != (b.angle > 0.0) && (b.first - a.last <= 3 || pause <= std::max(shorter, 0.0));
  };
  auto first = kept.begin() + center, last = first;
  while (first != kept.begin() && follows(*(first - 1), *first)) --first;
  while (last + 1 != kept.end() && follows(*last, *(last + 1))) ++last;
  return {first, last + 1};
}

// The sample from which the rudder moves without a stop to the held angle.
std::size_t movement_to(const Held& held, const std::vector<double>& delta) {
  const double side = held.angle < 0.0 ? -1.0 : 1.0;
  std::size_t i = held.first;
  while (i > 0 && side * (delta[i] - delta[i - 1]) > 0.0) --i;
  return i;
}

double time_of_change(const Trajectory& run, std::size_t from, double change) {
  const std::vector<double>&t = run[Channel::t], &psi = run[Channel::psi];
  for (std::size_t i = from; i < t.size(); ++i)
    if (std::abs(psi[i] - psi[from]) >= change) return t[i] - t[from];
  return t.back() - t[from];
}

// The sample of the order, and heading and course before it.
Approach approach_to(const Trajectory& run, std::size_t movement, double change, std::size_t& order) {
  const std::vector<double>&t = run[Channel::t], &x0 = run[Channel::x0], &y0 = run[Channel::y0],
        &psi = run[Channel::psi];
  const double window = kLateOrder * time_of_change(run, movement, change);
  order = t[movement] - t.front() < window ? 0 : movement;
  std::size_t first = movement;
  while (first > 0 && t[movement] - t[first - 1] <= window) --first;
  const std::size_t from = std::max(first, order == 0 ? std::size_t{0} : first);
  const std::vector<double> headings(psi.begin() + static_cast<std::ptrdiff_t>(order),
                                     psi.begin() + static_cast<std::ptrdiff_t>(movement) + 1);
  Approach approach{t[order], order < movement ? median(headings) : psi[order], psi[order]};
  const double speed = std::hypot(run[Channel::u][movement], run[Channel::vm][movement]);
  const double dx = x0[movement] - x0[from], dy = y0[movement] - y0[from];
  const bool is_known = from < movement && std::hypot(dx, dy) > 0.5 * speed * (t[movement] - t[from]) && speed > 0.0;
  const double course =
      is_known ? std::atan2(dy, dx) : psi[order] + std::atan2(run[Channel::vm][order], run[Channel::u][order]);
  approach.course = approach.heading + wrap_angle(course - approach.heading);
  return approach;
}

// The roundest angle between two [rad].
double roundest(double low, double high) {
  for (const double step : {5.0 * kDegree, kDegree, 0.5 * kDegree}) {
    const double multiple = step * std::round(0.5 * (low + high) / step);
    const double nearest = multiple < low ? multiple + step : multiple > high ? multiple - step : multiple;
    if (nearest > 0.0 && nearest >= low && nearest <= high) return nearest;
  }
  return 0.5 * (low + high);
}

// The last sample before the rudder leaves a held angle.
std::size_t movement_from(const Held& held, const std::vector<double>& delta) {
  const double side = held.angle < 0.0 ? -1.0 : 1.0;
  std::size_t i = held.last;
  while (i > held.first && side * (delta[i] - delta[i - 1]) < 0.0) --i;
  return i;
}

// Heading of a zigzag and what it is counted from.
void find_zigzag_heading(const Trajectory& run, const std::vector<double>& delta, const std::vector<Held>& angles,
                         RecordedManeuver& maneuver) {
  const std::vector<double>& psi = run[Channel::psi];
  std::vector<double> before, after;  // at each time that the rudder is put over
  for (const Held& held : angles) {
    if (held.last + 1 >= psi.size()) break;
    const std::size_t last = movement_from(held, delta);
    before.push_back(psi[last]);
    after.push_back(psi[last + 1]);
  }
  const auto middle = [&](std::size_t k) { return 0.5 * (before[k] + after[k]); };
  double scatter = 0.05 * kDegree, base = 0.0;
  for (std::size_t k = 0; k < before.size(); ++k) scatter = std::max(scatter, 0.5 * std::abs(after[k] - before[k]));
  for (std::size_t k = 0; k + 1 < before.size(); ++k)
    base += 0.5 * (middle(k) + middle(k + 1)) / static_cast<double>(before.size() - 1);
  if (before.size() > 1 && std::abs(base - maneuver.approach.heading) > scatter) maneuver.approach.heading = base;
  std::vector<double> low, high;
  for (std::size_t k = 0; k < before.size(); ++k) {
    const double a = std::abs(before[k] - maneuver.approach.heading),
                 b = std::abs(after[k] - maneuver.approach.heading);
    low.push_back(std::min(a, b));
    high.push_back(std::max(a, b));
  }
  if (!low.empty()) maneuver.heading = roundest(median(low) - kSwitchingLag, median(high) + 0.5 * kSwitchingLag);
}

}  // namespace

RecordedManeuver recognize_maneuver(const Trajectory& trajectory) {
  RecordedManeuver maneuver;
  const std::vector<double>&t = trajectory[Channel::t], &psi = trajectory[Channel::psi];
  const std::vector<double> delta = rudder_of(trajectory);
  if (delta.empty()) return maneuver;
  const std::vector<Held> all = held_angles(delta, psi);
  if (all.empty()) return maneuver;
  const std::vector<Held> angles = chain(all, t);
  if (angles.size() < 2 && angles.front().turn < kLeastTurning) return maneuver;
  maneuver.name = angles.size() > 1 ? "zigzag" : "turning";

  std::vector<double> sizes;
  for (const Held& held : angles) sizes.push_back(std::abs(held.angle));
  const double side = angles.front().angle < 0.0 ? -1.0 : 1.0, size = median(sizes);
  const double whole = kDegree * std::round(size / kDegree);
  maneuver.measured_rudder = side * size;
  maneuver.rudder = side * (std::abs(size - whole) <= kWholeDegree ? whole : size);
  maneuver.end_s = t[angles.back().last];

  const std::size_t movement = movement_to(angles.front(), delta);
  std::size_t order = 0;
  const double change =
      angles.size() > 1 ? std::min(10.0 * kDegree, std::abs(psi[angles.front().last] - psi[movement])) : 10.0 * kDegree;
  maneuver.approach = approach_to(trajectory, movement, change, order);
  if (angles.size() > 1) find_zigzag_heading(trajectory, delta, angles, maneuver);
  return maneuver;
}

}  // namespace leeway
