#include "foreign/anonymous_columns.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/units.hpp"
#include "foreign/rudder_fit.hpp"
#include "recording/trajectory.hpp"

namespace leeway::foreign {
namespace {

using Columns = std::vector<std::vector<double>>;

constexpr double kLinear = 3e-3;     // rms off a line, by what it spans
constexpr double kFollows = 0.7;     // direction of the track and heading
constexpr double kDerivative = 0.1;  // relative misfit of a position's derivative
constexpr double kRateFits = 0.3;    // relative misfit of a derivative
constexpr double kRateWeight = 3.0;  // of the misfit of a rate beside that of a direction, which holds the drift
constexpr double kPutOver = 0.7;     // range of a rudder by its largest angle; revolutions hardly change
constexpr double kSteady = 0.3;      // scatter of revolutions by their mean

struct Spread {
  double mean = 0.0, sd = 0.0, low = 1e300, high = -1e300, count = 0.0;
};

Spread spread_of(const std::vector<double>& values) {
  Spread s;
  for (const double x : values) {
    if (std::isnan(x)) continue;
    s.count += 1.0;
    s.mean += (x - s.mean) / s.count;
    s.low = std::min(s.low, x);
    s.high = std::max(s.high, x);
  }
  for (const double x : values)
    if (!std::isnan(x)) s.sd += (x - s.mean) * (x - s.mean);
  s.sd = s.count > 1.0 ? std::sqrt(s.sd / (s.count - 1.0)) : 0.0;
  return s;
}

// The share of samples in the three fullest of 100 bins: large for what is held at a few values, as a rudder.
double share_held(const std::vector<double>& values) {
  const Spread s = spread_of(values);
  if (!(s.high > s.low)) return 0.0;
  std::map<int, double> bins;
  for (const double x : values)
    if (!std::isnan(x)) bins[static_cast<int>(99.0 * (x - s.low) / (s.high - s.low))] += 1.0;
  std::vector<double> counts;
  for (const auto& [bin, count] : bins) counts.push_back(count);
  std::sort(counts.rbegin(), counts.rend());
  double most = 0.0;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, counts.size()); ++i) most += counts[i];
  return most / s.count;
}

// Every n-th sample: searching is over all triples of columns.
Columns thinned(const Columns& columns, std::vector<double>& t) {
  constexpr std::size_t kEnough = 3000;
  const std::size_t step = std::max<std::size_t>(1, t.size() / kEnough);
  Columns result(columns.size());
  std::vector<double> times;
  for (std::size_t i = 0; i < t.size(); i += step) times.push_back(t[i]);
  for (std::size_t c = 0; c < columns.size(); ++c)
    for (std::size_t i = 0; i < columns[c].size(); i += step) result[c].push_back(columns[c][i]);
  t = std::move(times);
  return result;
}

class Search {
 public:
  Search(const Columns& columns, const std::vector<bool>& taken, std::vector<double> t)
      : columns_(thinned(columns, t)), t_(t), windows_(std::move(t)), free_(columns.size()) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const Spread s = spread_of(columns_[c]);
      free_[c] = !taken[c] && s.count > 0.9 * static_cast<double>(columns_[c].size());
      moves_.push_back(free_[c] && s.high > s.low);
    }
  }

  AnonymousColumns run() {
    find_pose();
    if (!found_.psi) return found_;
    find_velocities();
    find_yaw_rate();
    find_rudder();
    find_propeller();
    return found_;
  }

 private:
  void take(std::optional<std::size_t>& role, std::size_t column) {
    role = column;
    free_[column] = moves_[column] = false;
  }

  // Whether a column is the derivative of another one, as a velocity along the earth's axes is of a position.
  bool is_derivative(std::size_t column) const {
    for (std::size_t p = 0; p < columns_.size(); ++p) {
      if (p == column || !moves_[p]) continue;
      double square = 0.0, product = 0.0, whole = 0.0;
      for (std::size_t w = 0; w < windows_.size(); ++w) {
        const double increment = windows_.increment(w, columns_[p]), integral = windows_.integral(w, columns_[column]);
        if (std::isnan(increment + integral)) continue;
        square += integral * integral;
        product += integral * increment;
        whole += increment * increment;
      }
      if (!(square > 0.0 && whole > 0.0) || 1.0 - product * product / square / whole > kDerivative * kDerivative)
        continue;
      // In a circle around the origin one coordinate is the other one's derivative, but in no unit of speed.
      for (const std::string_view unit : io::units_of(Quantity::speed))
        if (std::abs(std::abs(product / square) / io::unit_of(Quantity::speed, unit)->factor - 1.0) < kDerivative)
          return true;
    }
    return false;
  }

  // The heading is what both the track's direction and a yaw rate follow.
  void find_pose() {
    const std::size_t n = columns_.size();
    std::vector<bool> may_be_position = moves_;
    for (std::size_t c = 0; c < n; ++c)
      if (moves_[c] && is_derivative(c)) may_be_position[c] = false;
    double best = kFollows + kRateWeight * kRateFits;
    std::size_t x0 = n, y0 = n, psi = n;
    for (std::size_t p = 0; p < n; ++p) {
      if (!moves_[p]) continue;
      double rate = 1.0;
      for (std::size_t r = 0; r < n; ++r)
        if (r != p && moves_[r]) rate = std::min(rate, fit_yaw(windows_, columns_[p], "", columns_[r], "").misfit);
      if (rate > kRateFits) continue;
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b) {
          if (a == b || a == p || b == p || !may_be_position[a] || !may_be_position[b]) continue;
          // A velocity to the east follows the direction as well, but no rate is its derivative to a few percent.
          const double direction = fit_direction(windows_, columns_[a], columns_[b], columns_[p], "").misfit;
          const double misfit = direction + kRateWeight * rate;
          if (direction >= kFollows || misfit >= best) continue;
          best = misfit;
          x0 = a;
          y0 = b;
          psi = p;
        }
    }
    if (psi == n) return;
    take(found_.x0, x0);
    take(found_.y0, y0);
    take(found_.psi, psi);
  }

  void find_velocities() {
    const std::size_t n = columns_.size();
    double best = kFits;
    std::size_t u = n, vm = n;
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b) {
        if (a == b || !moves_[a] || !moves_[b]) continue;
        MotionColumns c{columns_[*found_.x0],
                        columns_[*found_.y0],
                        columns_[*found_.psi],
                        columns_[a],
                        columns_[b],
                        "",
                        "",
                        "",
                        {}};
        c.frames = {io::VelocityFrame::ship, io::VelocityFrame::earth, io::VelocityFrame::course_and_speed};
        const MotionFit fit = fit_motion(windows_, c);
        if (fit.misfit >= best) continue;
        best = fit.misfit;
        u = a;
        vm = b;
        found_.frame = fit.frame;
      }
    if (u == n) return;
    take(found_.u, u);
    take(found_.vm, vm);
  }

  void find_yaw_rate() {
    double best = kRateFits;
    std::size_t rate = columns_.size();
    for (std::size_t r = 0; r < columns_.size(); ++r) {
      if (!moves_[r]) continue;
      const double misfit = fit_yaw(windows_, columns_[*found_.psi], "", columns_[r], "").misfit;
      if (misfit >= best) continue;
      best = misfit;
      rate = r;
    }
    if (rate < columns_.size()) take(found_.r, rate);
  }

  void find_rudder() {
    if (!found_.r) return;
    double best = 0.0;
    std::size_t rudder = columns_.size();
    std::vector<double> speed;
    if (found_.u) speed = columns_[*found_.u];
    if (found_.u && found_.frame != io::VelocityFrame::course_and_speed)
      for (std::size_t i = 0; i < speed.size(); ++i) speed[i] = std::hypot(speed[i], columns_[*found_.vm][i]);
    for (std::size_t d = 0; d < columns_.size(); ++d) {
      if (!moves_[d]) continue;
      const RudderResponse response =
          fit_rudders(windows_, {t_, columns_[*found_.r], speed, {columns_[d]}, {}}).front();
      // One that is put over once and held says more by the side to which the ship then turns.
      const Spread range = spread_of(columns_[d]);
      const bool is_put_over = range.high - range.low > kPutOver * std::max(std::abs(range.high), std::abs(range.low));
      const bool is_held = is_put_over && std::abs(response.held) >= kClearSide;
      const double strength = std::max(std::min(response.significance, 100.0), is_held ? kSignificant : 0.0);
      const double score = strength * std::pow(share_held(columns_[d]), 2);
      if (strength < kSignificant || score <= best) continue;
      best = score;
      rudder = d;
    }
    if (rudder < columns_.size()) take(found_.delta, rudder);
  }

  void find_propeller() {
    double best = kSteady;
    std::size_t propeller = columns_.size();
    for (std::size_t n = 0; n < columns_.size(); ++n) {
      if (!free_[n]) continue;
      const Spread s = spread_of(columns_[n]);
      if (!(s.mean > 0.0) || s.sd / s.mean >= best) continue;
      best = s.sd / s.mean;
      propeller = n;
    }
    if (propeller < columns_.size()) take(found_.n_p, propeller);
  }

  Columns columns_;
  std::vector<double> t_;
  Windows windows_;
  std::vector<bool> free_, moves_;
  AnonymousColumns found_;
};

}  // namespace

std::optional<LinearClock> find_linear_clock(const Columns& columns) {
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::vector<double>& t = columns[c];
    const auto n = static_cast<double>(t.size());
    if (t.size() < 8 || std::any_of(t.begin(), t.end(), [](double x) { return std::isnan(x); })) continue;
    double covariance = 0.0, variance = 0.0, mean = 0.0, squares = 0.0;
    for (const double x : t) mean += x / n;
    bool is_increasing = true, falls = false;
    for (std::size_t i = 0; i < t.size(); ++i) {
      const double row = static_cast<double>(i) - 0.5 * (n - 1.0);
      covariance += row * (t[i] - mean);
      variance += row * row;
      if (i == 0) continue;
      is_increasing = is_increasing && t[i] - t[i - 1] >= kSameTime_s;
      falls = falls || t[i] < t[i - 1];
    }
    const double step = covariance / variance;
    for (std::size_t i = 0; i < t.size(); ++i)
      squares += std::pow(t[i] - mean - step * (static_cast<double>(i) - 0.5 * (n - 1.0)), 2);
    if (step > 0.0 && !falls && std::sqrt(squares / n) < kLinear * step * n) return LinearClock{c, step, is_increasing};
  }
  return std::nullopt;
}

AnonymousColumns recognize_columns(const Columns& columns, const std::vector<bool>& taken,
                                   const std::vector<double>& t) {
  return Search(columns, taken, t).run();
}

}  // namespace leeway::foreign
