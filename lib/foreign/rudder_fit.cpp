#include "foreign/rudder_fit.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra.hpp"
#include "core/statistics.hpp"

namespace leeway::foreign {
namespace {

constexpr std::size_t kBlock = 6;          // windows whose errors may hang together
constexpr double kHeldRoom = 0.2;          // how far a rudder moves that is held, by its largest angle
constexpr double kLeastHeld = 0.3;         // an angle that is put over, by the largest one
constexpr double kLargestQuantile = 0.95;  // leaves wild values out

double scale_of(std::span<const double> values) {
  std::vector<double> sizes;
  for (const double x : values)
    if (!std::isnan(x)) sizes.push_back(std::abs(x));
  std::sort(sizes.begin(), sizes.end());
  return sizes.empty() ? 0.0 : quantile(sizes, kLargestQuantile);
}

// What the rudder's angles, over the last half of the time that each is held, do with the heading.
double held_side(const SteeringColumns& c, std::span<const double> delta) {
  const double scale = scale_of(delta);
  double with = 0.0, against = 0.0;
  for (std::size_t i = 0; i < delta.size();) {
    if (std::isnan(delta[i])) {
      ++i;
      continue;
    }
    double low = delta[i], high = delta[i];
    std::size_t end = i + 1;
    for (; end < delta.size(); ++end) {
      if (std::isnan(delta[end]) || std::isnan(c.r[end])) continue;
      if (std::max(high, delta[end]) - std::min(low, delta[end]) > kHeldRoom * scale) break;
      low = std::min(low, delta[end]);
      high = std::max(high, delta[end]);
    }
    const double angle = 0.5 * (low + high);
    double turn = 0.0;
    for (std::size_t k = (i + end) / 2; k + 1 < end; ++k)
      if (const double step = 0.5 * (c.r[k] + c.r[k + 1]) * (c.t[k + 1] - c.t[k]); !std::isnan(step)) turn += step;
    if (std::abs(angle) > kLeastHeld * scale) (turn * angle > 0.0 ? with : against) += std::abs(turn);
    i = end;
  }
  return with + against > 0.0 ? (with - against) / (with + against) : 0.0;
}

struct Regression {
  Eigen::VectorXd fit, sd;
  double squares = 0.0;  // of what is left over
  bool is_known = false;
};

// Least squares; the standard deviations count what is left over in whole blocks of rows.
Regression regress(const Eigen::MatrixXd& x, const Eigen::VectorXd& y) {
  const Eigen::Index n = x.rows(), p = x.cols();
  Regression regression;
  if (n < 2 * p + 2) return regression;
  const Eigen::MatrixXd normal = x.transpose() * x;
  const Eigen::MatrixXd inverse = (normal + 1e-12 * normal.trace() * Eigen::MatrixXd::Identity(p, p)).inverse();
  regression.fit = inverse * (x.transpose() * y);
  const Eigen::VectorXd left = y - x * regression.fit;
  regression.squares = left.squaredNorm();
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(p, p);
  for (Eigen::Index first = 0; first < n; first += static_cast<Eigen::Index>(kBlock)) {
    const Eigen::Index length = std::min<Eigen::Index>(static_cast<Eigen::Index>(kBlock), n - first);
    const Eigen::VectorXd score = x.middleRows(first, length).transpose() * left.segment(first, length);
    scatter += score * score.transpose();
  }
  const Eigen::MatrixXd independent = inverse * (regression.squares / static_cast<double>(n - p));
  const Eigen::MatrixXd blocks = inverse * scatter * inverse;
  regression.sd = independent.diagonal().cwiseMax(blocks.diagonal()).cwiseMax(0.0).cwiseSqrt();
  regression.is_known = true;
  return regression;
}

// Each column by its largest value, so that units do not matter; with U or without.
Regression steering_law(const Windows& windows, const SteeringColumns& c, bool with_speed) {
  const std::size_t n = c.r.size();
  const double u_scale = with_speed ? scale_of(c.speed) : 1.0;
  std::vector<double> speed(n, 1.0);
  for (std::size_t i = 0; with_speed && u_scale > 0.0 && i < n; ++i) speed[i] = c.speed[i] / u_scale;
  std::vector<std::vector<double>> terms;
  const auto add = [&](std::span<const double> values, auto power) {
    const double scale = scale_of(values);
    std::vector<double> term(n);
    for (std::size_t i = 0; i < n; ++i) term[i] = power(speed[i], scale > 0.0 ? values[i] / scale : 0.0);
    terms.push_back(std::move(term));
  };
  for (const std::span<const double>& delta : c.rudders) add(delta, [](double U, double d) { return U * U * d; });
  add(c.r, [](double U, double r) { return U * r; });
  add(std::vector<double>(n, 1.0), [](double U, double one) { return U * U * one; });
  for (const std::span<const double>& revolutions : c.thrusters)
    if (scale_of(revolutions) > 0.0) add(revolutions, [](double, double m) { return m * std::abs(m); });
  const double r_scale = scale_of(c.r);
  std::vector<std::vector<double>> rows;
  std::vector<double> answers;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    std::vector<double> row;
    double sum = answers.emplace_back(windows.increment(w, c.r) / (r_scale > 0.0 ? r_scale : 1.0));
    for (const std::vector<double>& term : terms)
      sum += row.emplace_back(windows.integral(w, term) / windows.length_s(w));
    if (std::isnan(sum))
      answers.pop_back();
    else
      rows.push_back(std::move(row));
  }
  Eigen::MatrixXd x(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(terms.size()));
  Eigen::VectorXd y(x.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    y(i) = answers[static_cast<std::size_t>(i)];
    for (Eigen::Index k = 0; k < x.cols(); ++k)
      x(i, k) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
  }
  return regress(x, y);
}

}  // namespace

bool RudderResponse::is_contradictory() const {
  return significance >= kSignificant && std::abs(held) >= kClearSide && b * held < 0.0;
}

double RudderResponse::side(bool is_alone) const {
  if (is_contradictory() && !is_alone) return 0.0;
  if (std::abs(held) >= kClearSide) return held > 0.0 ? 1.0 : -1.0;
  if (significance >= kSignificant) return b > 0.0 ? 1.0 : -1.0;
  return 0.0;
}

std::vector<RudderResponse> fit_rudders(const Windows& windows, const SteeringColumns& columns) {
  std::vector<RudderResponse> responses(columns.rudders.size());
  Regression best = steering_law(windows, columns, false);
  if (!columns.speed.empty())
    if (const Regression law = steering_law(windows, columns, true); law.is_known && law.squares < best.squares)
      best = law;
  for (std::size_t k = 0; k < responses.size(); ++k) {
    if (scale_of(columns.rudders[k]) == 0.0) continue;
    responses[k].held = held_side(columns, columns.rudders[k]);
    if (!best.is_known) continue;
    const auto i = static_cast<Eigen::Index>(k);
    responses[k].b = best.fit(i);
    responses[k].significance = best.sd(i) > 0.0 ? std::abs(best.fit(i)) / best.sd(i) : 1e9;
  }
  return responses;
}

}  // namespace leeway::foreign
