#pragma once

#include <functional>
#include <vector>

#include "gap/detect/score_test.hpp"
#include "gap/fit/null_fit.hpp"

/// Accelerations that follow from what the ship does and feels: what recordings say about them.
namespace leeway::gap {

/// What the ship does and feels in the middle of a step: (u, v [m/s], r [rad/s]) at midship, as recorded.
struct Moment {
  double t_s = 0.0, u = 0.0, v = 0.0, r = 0.0, U = 0.0, psi = 0.0, x0 = 0.0, y0 = 0.0;
  Vec2<double> apparent = Vec2<double>::Zero();  ///< wind [m/s], from-vector in ship axes
  Actuators<double> actuators;
};
Moment moment_of(const LinearStretch& stretch, std::size_t k);

/// An acceleration in units of reference_acceleration(), up to a factor.
using Pattern = std::function<Vec3<double>(const Moment&)>;

/// The patterns' evidence, projected; columns are scaled to a root mean square of one unit.
struct PatternEvidence {
  Projected projected;
  Eigen::VectorXd scale;
  std::vector<Eigen::MatrixXd> values;  ///< per stretch: 3 x (steps * columns), scaled
};
PatternEvidence pattern_evidence(const Campaign& campaign, const FittedNull& fit, const std::vector<Pattern>& patterns,
                                 std::size_t jobs);

/// Share of the residual's energy that a least-squares combination of some columns takes.
///   residual      of smoothed_residual()
///   first, count  the columns
///   axis          on which alone; -1: all
double share_of(const PatternEvidence& evidence, const std::vector<Eigen::Matrix3Xd>& residual, Eigen::Index first,
                Eigen::Index count, int axis);

}  // namespace leeway::gap
