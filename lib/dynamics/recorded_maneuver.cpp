#include "dynamics/recorded_maneuver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/statistics.hpp"
#include "core/units.hpp"

namespace leeway {
namespace {

constexpr double kHeld = 0.5 * kDegree, kHeldShare = 0.04;  // how far a rudder that is held moves
constexpr double kLeastRudder = 2.9 * kDegree;
constexpr double kNoiseRoom = 3.0;           // standard deviations
constexpr double kResolutionRoom = 0.75;     // of the steps in which a rudder is recorded
constexpr double kQuiet = 0.02 * kDegree;    // noise up to which every movement is one
constexpr double kSmoothed = 0.1 * kDegree;  // noise from which on medians are taken
constexpr double kOfMain = 0.5;              // a rudder angle that belongs to an execute, by the largest one's
constexpr double kSameAmplitude = 0.3;       // relative difference of angles of one zigzag
constexpr double kLeastTurning = 30.0 * kDegree;
constexpr double kWholeDegree = 0.35 * kDegree;
constexpr double kLateOrder = 0.25;  // of the time to 10 deg
constexpr double kSwitchingLag = 0.6 * kDegree;
constexpr double kMostExecutes = 0.75;  // of the times that the rudder is put over have the heading between two

// The rudder as recorded, and how well that is.
struct Feedback {
  std::vector<double> delta;  // [rad]
  double tolerance = kHeld;   // up to which two angles are the same [rad]
  double noise = 0.0;         // standard deviation [rad]
  double resolution = 0.0;    // smallest difference [rad]
};

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

double median_of(const std::vector<double>& values, std::size_t first, std::size_t last) {
  return median(
      {values.begin() + static_cast<std::ptrdiff_t>(first), values.begin() + static_cast<std::ptrdiff_t>(last) + 1});
}

// Medians of five leave what rises or falls steadily as it is.
std::vector<double> running_median(const std::vector<double>& values) {
  std::vector<double> result = values;
  for (std::size_t i = 2; i + 2 < values.size(); ++i) result[i] = median_of(values, i - 2, i + 2);
  return result;
}

Feedback feedback_of(std::vector<double> delta) {
  constexpr double kOfNormal = 0.6745, kSecondDifference = 2.449489742783178;  // median by sd; sqrt(6)
  constexpr double kRounding = 1e-6 * kDegree, kOfStep = 0.01, kCoarsest = 2.0 * kDegree;
  constexpr std::ptrdiff_t kOften = 8;
  Feedback rudder;
  std::vector<double> bends, steps;
  for (std::size_t i = 1; i < delta.size(); ++i) {
    if (const double step = std::abs(delta[i] - delta[i - 1]); step > kRounding) steps.push_back(step);
    if (i > 1) bends.push_back(std::abs(delta[i] - 2.0 * delta[i - 1] + delta[i - 2]));
  }
  if (!steps.empty()) {  // rounded: all steps are multiples of the smallest, which comes often
    const double smallest = *std::min_element(steps.begin(), steps.end());
    const auto is_multiple = [&](double step) { return std::abs(std::remainder(step, smallest)) < kOfStep * smallest; };
    const auto of_smallest =
        std::count_if(steps.begin(), steps.end(), [&](double step) { return step < (1.0 + kOfStep) * smallest; });
    if (smallest <= kCoarsest && of_smallest >= kOften && std::all_of(steps.begin(), steps.end(), is_multiple))
      rudder.resolution = smallest;
  }
  rudder.noise = bends.empty() ? 0.0 : median(bends) / (kOfNormal * kSecondDifference);
  rudder.tolerance = std::max({kHeld, kResolutionRoom * rudder.resolution, kNoiseRoom * rudder.noise});
  rudder.delta = rudder.noise > kSmoothed ? running_median(delta) : std::move(delta);
  return rudder;
}

double room_at(double angle, const Feedback& rudder) {
  return 2.0 * std::max(rudder.tolerance, kHeldShare * std::abs(angle));
}

// The held angle during which the ship turns most: it tells how far the rudder is put over.
double main_angle(const Feedback& rudder, const std::vector<double>& psi) {
  const std::vector<double>& delta = rudder.delta;
  double angle = 0.0, most = -1.0;
  for (std::size_t i = 0; i < delta.size();) {
    double low = delta[i], high = delta[i];
    std::size_t last = i;
    while (last + 1 < delta.size()) {
      const double next = delta[last + 1];
      if (std::max(high, next) - std::min(low, next) > room_at(std::max(std::abs(low), std::abs(high)), rudder)) break;
      low = std::min(low, next);
      high = std::max(high, next);
      ++last;
    }
    const double turn = std::abs(psi[last] - psi[i]);
    if (last > i && turn > most)
      if (const double held = median_of(delta, i, last); std::abs(held) >= kLeastRudder) {
        most = turn;
        angle = held;
      }
    i = last + 1;
  }
  return angle;
}

// Every time that the rudder is put over by about the main angle, also if it turns back before it is there.
std::vector<Held> executes(const Feedback& rudder, const std::vector<double>& psi, double main) {
  const std::vector<double>& delta = rudder.delta;
  const double size = std::abs(main), least = kOfMain * size, most = (1.0 + kSameAmplitude) * size + rudder.tolerance;
  const double slack = std::min(rudder.tolerance, 0.5 * least);
  std::vector<Held> all;
  for (std::size_t i = 0; i < delta.size(); ++i) {
    const double side = delta[i] < 0.0 ? -1.0 : 1.0;
    if (side * delta[i] < least || side * delta[i] > most) continue;
    std::size_t end = i, first = i;
    double peak = 0.0;
    for (; end < delta.size() && side * delta[end] >= least - slack && side * delta[end] <= most; ++end)
      peak = std::max(peak, side * delta[end]);
    const double low = peak - room_at(peak, rudder);
    while (side * delta[first] < low) ++first;
    std::size_t last = end - 1;
    while (side * delta[last] < low) --last;
    all.push_back({first, last, median_of(delta, first, last), std::abs(psi[last] - psi[first])});
    i = end - 1;
  }
  return all;
}

// Whether the rudder goes from one angle to the other without a stop, but for noise.
bool goes_straight(const Held& a, const Held& b, const Feedback& rudder) {
  const double side = b.angle < 0.0 ? -1.0 : 1.0;
  double furthest = side * a.angle;
  for (std::size_t i = a.last; i <= b.first; ++i) {
    if (side * rudder.delta[i] < furthest - rudder.tolerance) return false;
    furthest = std::max(furthest, side * rudder.delta[i]);
  }
  return true;
}

// The executes of one maneuver: around the one that turns the ship most, those that alternate with it.
std::vector<Held> chain(const std::vector<Held>& all, const Feedback& rudder, double main,
                        const std::vector<double>& t) {
  const auto is_like = [&](const Held& held) { return std::abs(held.angle) > (1.0 - kSameAmplitude) * std::abs(main); };
  const auto pause = [&](const Held& a, const Held& b) { return t[b.first] - t[a.last]; };
  const auto follows = [&](const Held& a, const Held& b) {
    if ((a.angle > 0.0) == (b.angle > 0.0)) return false;
    const double a_s = t[a.last] - t[a.first], b_s = t[b.last] - t[b.first];
    const bool is_straight = goes_straight(a, b, rudder);
    // An execute that turned back early has a smaller angle, and is never held.
    if ((!is_like(a) && a_s > pause(a, b)) || (!is_like(b) && b_s > pause(a, b))) return false;
    return is_straight || (is_like(a) && is_like(b) && pause(a, b) <= std::min(a_s, b_s));
  };
  const auto center = std::max_element(all.begin(), all.end(), [&](const Held& a, const Held& b) {
    return (is_like(a) ? a.turn : -1.0) < (is_like(b) ? b.turn : -1.0);
  });
  auto first = center, last = center;
  while (first != all.begin() && follows(*(first - 1), *first)) --first;
  while (last + 1 != all.end() && follows(*last, *(last + 1))) ++last;
  return {first, last + 1};
}

// The last sample before the rudder moves to the first held angle: the last at which it was where it had rested before,
// for as long as it then takes for twice the tolerance.
std::size_t movement_to(const Held& held, const Feedback& rudder, const std::vector<double>& t) {
  const std::vector<double>& delta = rudder.delta;
  const double side = held.angle < 0.0 ? -1.0 : 1.0;
  std::size_t half = held.first;
  while (half > 0 && side * delta[half] > 0.5 * std::abs(held.angle)) --half;
  const double moved = side * (delta[held.first] - delta[half]);
  const double rest_s = moved > 0.0 ? 2.0 * rudder.tolerance / moved * (t[held.first] - t[half]) : 0.0;
  std::size_t to = half, from = half;
  for (;; --to) {
    double low = delta[to], high = low;
    for (from = to; from > 0 && (from == to || t[to] - t[from] < rest_s); --from) {
      low = std::min(low, delta[from - 1]);
      high = std::max(high, delta[from - 1]);
    }
    if (to == 0 || high - low <= rudder.tolerance) break;
  }
  while (from > 0 && std::abs(delta[from - 1] - delta[to]) <= rudder.tolerance) --from;
  const double before = side * median_of(delta, from, to);
  std::size_t i = held.first;
  while (i > to && side * delta[i] > before + rudder.tolerance) --i;
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

// The roundest angle between two that are measured [rad], but first a multiple of 5 deg that a steering gear which
// follows late would have made of; the middle where there is none.
double roundest(double low, double high) {
  const auto between = [](double step, double least, double most) {
    const double multiple = step * std::round(0.5 * (least + most) / step);
    const double nearest = multiple < least ? multiple + step : multiple > most ? multiple - step : multiple;
    return nearest > 0.0 && nearest >= least && nearest <= most ? nearest : 0.0;
  };
  const double least = low - kSwitchingLag, most = high + 0.5 * kSwitchingLag;
  for (const double angle :
       {between(5.0 * kDegree, least, most), between(kDegree, low, high), between(0.5 * kDegree, low, high)})
    if (angle > 0.0) return angle;
  return least <= kDegree && kDegree <= most ? kDegree : 0.5 * (low + high);
}

// The last samples before the rudder leaves a held angle: of no movement, and within the tolerance.
std::pair<std::size_t, std::size_t> movement_from(const Held& held, const Feedback& rudder) {
  const std::vector<double>& delta = rudder.delta;
  const double side = held.angle < 0.0 ? -1.0 : 1.0;
  std::size_t within = held.last;
  while (within > held.first && side * delta[within] < side * held.angle - rudder.tolerance) --within;
  std::size_t still = within;
  while (still > held.first && side * (delta[still] - delta[still - 1]) < 0.0) --still;
  return {still, within};
}

// Heading of a zigzag and what it is counted from.
void find_zigzag_heading(const Trajectory& run, const Feedback& rudder, const std::vector<Held>& angles,
                         RecordedManeuver& maneuver) {
  const std::vector<double>& psi = run[Channel::psi];
  std::vector<double> before, after;  // at each time that the rudder is put over
  for (const Held& held : angles) {
    if (held.last + 1 >= psi.size()) break;
    const auto [still, within] = movement_from(held, rudder);
    before.push_back(psi[still > 0 ? still - 1 : 0]);  // the order was up to a sample earlier than the movement
    after.push_back(psi[(rudder.noise > kQuiet ? within : still) + 1]);
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
  if (low.empty()) return;
  std::sort(low.begin(), low.end());
  std::sort(high.begin(), high.end());
  maneuver.least_heading = quantile(low, kMostExecutes);
  maneuver.most_heading = quantile(high, 1.0 - kMostExecutes);
  if (maneuver.least_heading > maneuver.most_heading) std::swap(maneuver.least_heading, maneuver.most_heading);
  maneuver.heading = roundest(maneuver.least_heading, maneuver.most_heading);
}

}  // namespace

RecordedManeuver recognize_maneuver(const Trajectory& trajectory) {
  RecordedManeuver maneuver;
  const std::vector<double>&t = trajectory[Channel::t], &psi = trajectory[Channel::psi];
  std::vector<double> recorded = rudder_of(trajectory);
  if (recorded.empty()) return maneuver;
  const Feedback rudder = feedback_of(std::move(recorded));
  const double main = main_angle(rudder, psi);
  if (main == 0.0) return maneuver;
  const std::vector<Held> angles = chain(executes(rudder, psi, main), rudder, main, t);
  if (angles.size() < 2 && angles.front().turn < kLeastTurning) return maneuver;
  maneuver.name = angles.size() > 1 ? "zigzag" : "turning";

  std::vector<double> sizes;
  for (const Held& held : angles) sizes.push_back(std::abs(held.angle));
  const double side = angles.front().angle < 0.0 ? -1.0 : 1.0, size = median(sizes);
  const double whole = kDegree * std::round(size / kDegree);
  maneuver.measured_rudder = side * size;
  maneuver.rudder = side * (std::abs(size - whole) <= kWholeDegree ? whole : size);
  maneuver.end_s = t[angles.back().last];

  const Held& execute = angles.front();
  const std::size_t movement = movement_to(execute, rudder, t);
  std::size_t order = 0;
  const double change =
      angles.size() > 1 ? std::min(10.0 * kDegree, std::abs(psi[execute.last] - psi[movement])) : 10.0 * kDegree;
  maneuver.approach = approach_to(trajectory, movement, change, order);
  if (rudder.tolerance > kHeld)
    maneuver.order_doubt_s = rudder.tolerance / std::abs(rudder.delta[execute.first] - rudder.delta[movement]) *
                             (t[execute.first] - t[movement]);
  maneuver.noise = rudder.noise;
  maneuver.resolution = rudder.resolution;
  if (angles.size() > 1) find_zigzag_heading(trajectory, rudder, angles, maneuver);
  return maneuver;
}

}  // namespace leeway
