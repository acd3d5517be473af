#include "gap/locate/line_of_action.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gap/filter/reference_units.hpp"
#include "gap/locate/residuals.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

std::optional<Estimate> line_of_action(const Campaign& campaign, const FittedNull& fit,
                                       const std::vector<Block>& blocks,
                                       const std::vector<Eigen::Matrix3Xd>& residual) {
  const Mat3<double> M = inertia_matrix(campaign.ship);
  const Vec3<double> unit = reference_acceleration(campaign.ship);
  const auto group_points = static_cast<std::size_t>(kPolicy.locate.group_taus * fit.noise.tau_s / campaign.step_s) + 1;
  std::vector<Vec2<double>> sums;  // (N Y, Y Y)
  std::size_t points = group_points;
  for (const Block& block : blocks) {
    if (points >= group_points) {
      sums.push_back(Vec2<double>::Zero());
      points = 0;
    }
    points += block.end - block.begin;
    const Eigen::Matrix3Xd& w = residual[block.stretch];
    for (auto k = static_cast<Eigen::Index>(block.begin); k < std::min<Eigen::Index>(block.end, w.cols()); ++k) {
      const Vec3<double> force = M * w.col(k).cwiseProduct(unit);
      sums.back() += Vec2<double>(force(2) * force(1), force(1) * force(1));
    }
  }
  const Vec2<double> total = std::accumulate(sums.begin(), sums.end(), Vec2<double>(0.0, 0.0));
  const double L = campaign.ship.particulars.L_pp, x_F = total(0) / total(1);
  double variance = 0.0;
  const auto n = static_cast<double>(sums.size());
  for (const Vec2<double>& sum : sums) {
    const double without = (total(0) - sum(0)) / (total(1) - sum(1));
    variance += (without - x_F) * (without - x_F) * (n - 1.0) / n;
  }
  if (sums.size() < kPolicy.locate.least_groups || !std::isfinite(x_F) || !std::isfinite(variance)) return std::nullopt;
  return Estimate{"x_F_over_L", x_F / L, std::sqrt(variance) / L};
}

std::optional<Estimate> line_of_action(const Campaign& campaign, const std::vector<Interval>& intervals) {
  const Mat3<double> M = inertia_matrix(campaign.ship);
  double NY = 0.0, YY = 0.0, variance = 0.0;
  for (const Interval& interval : intervals) {
    const Vec3<double> F = M * interval.acceleration;
    NY += F(2) * F(1);
    YY += F(1) * F(1);
  }
  const double x_F = NY / YY;
  for (const Interval& interval : intervals) {
    const Vec3<double> F = M * interval.acceleration;
    const Mat3<double> P = M * interval.covariance * M.transpose();
    variance += F(1) * F(1) * (P(2, 2) + x_F * x_F * P(1, 1) - 2.0 * x_F * P(1, 2)) / (YY * YY);
  }
  const double L = campaign.ship.particulars.L_pp;
  // A side force that is hardly there has no line.
  if (!std::isfinite(x_F) || !(std::sqrt(variance) < kPolicy.locate.most_line_sd * L)) return std::nullopt;
  return Estimate{"x_F_over_L", x_F / L, std::sqrt(variance) / L};
}

}  // namespace leeway::gap
