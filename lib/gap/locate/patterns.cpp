#include "gap/locate/patterns.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/wind.hpp"
#include "gap/filter/reference_units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

Moment moment_of(const LinearStretch& stretch, std::size_t k) {
  Moment at;
  // On the way to where the simulator leads, not to where the recording then is: what drives her away in this step must
  // not be in what it is compared with.
  StateVector x = 0.5 * (stretch.path[k] + stretch.path[k + 1]);
  x.head<kShipStates>() += 0.5 * stretch.steps[k].offset;
  const std::vector<StepInputs<double>>& inputs = stretch.data->inputs[k];
  const Inputs<double>& middle =
      inputs.size() % 2 == 1 ? inputs[inputs.size() / 2].middle : inputs[inputs.size() / 2].start;
  at.t_s = 0.5 * (stretch.data->t_s[k] + stretch.data->t_s[k + 1]);
  at.x0 = x[0], at.y0 = x[1], at.psi = x[2], at.u = x[3], at.v = x[4], at.r = x[5];
  at.U = std::hypot(at.u, at.v);
  at.apparent = apparent_wind<double>(middle.true_wind, at.psi, at.u, at.v);
  at.actuators = middle.actuators;
  return at;
}

PatternEvidence pattern_evidence(const Campaign& campaign, const FittedNull& fit, const std::vector<Pattern>& patterns,
                                 std::size_t jobs) {
  const auto count = static_cast<Eigen::Index>(patterns.size());
  const std::size_t n = fit.stretches.size();
  PatternEvidence result;
  result.values.resize(n);
  parallel_for(n, jobs, [&](std::size_t s) {
    const LinearStretch& stretch = fit.stretches[s];
    result.values[s].resize(3, static_cast<Eigen::Index>(stretch.steps.size()) * count);
    for (std::size_t k = 0; k < stretch.steps.size(); ++k) {
      const Moment at = moment_of(stretch, k);
      for (Eigen::Index c = 0; c < count; ++c)
        result.values[s].col(static_cast<Eigen::Index>(k) * count + c) = patterns[static_cast<std::size_t>(c)](at);
    }
  });
  Eigen::VectorXd square = Eigen::VectorXd::Zero(count);
  double steps = 0.0;
  for (const Eigen::MatrixXd& values : result.values)
    for (Eigen::Index i = 0; i < values.cols(); ++i) square[i % count] += values.col(i).squaredNorm();
  for (const LinearStretch& stretch : fit.stretches) steps += static_cast<double>(stretch.steps.size());
  result.scale = (square / steps).cwiseSqrt();
  for (double& x : result.scale) x = x > kPolicy.locate.least_pattern_rms ? 1.0 / x : 0.0;
  for (Eigen::MatrixXd& values : result.values)
    for (Eigen::Index i = 0; i < values.cols(); ++i) values.col(i) *= result.scale[i % count];

  const Vec3<double> unit = reference_acceleration(campaign.ship);
  std::vector<Evidence> parts(n);
  parallel_for(n, jobs, [&](std::size_t s) {
    const LinearStretch& stretch = fit.stretches[s];
    parts[s] = evidence(stretch, fit.noise, count, [&](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) {
      out.noalias() = stretch.steps[k].A.middleCols<3>(kErrorStart) *
                      (unit.asDiagonal() * result.values[s].middleCols(static_cast<Eigen::Index>(k) * count, count));
    });
  });
  Evidence total(fit.theta.size() + count);
  for (const Evidence& part : parts) total += part;
  result.projected = project(total, fit.theta, fit.prior);
  return result;
}

double share_of(const PatternEvidence& evidence, const std::vector<Eigen::Matrix3Xd>& residual, Eigen::Index first,
                Eigen::Index count, int axis) {
  const Eigen::Index all = evidence.scale.size();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(count);
  double energy = 0.0;
  for (std::size_t s = 0; s < residual.size(); ++s)
    for (Eigen::Index k = 0; k < residual[s].cols(); ++k)
      for (int i = axis < 0 ? 0 : axis; i <= (axis < 0 ? 2 : axis); ++i) {
        const auto x = evidence.values[s].row(i).segment(k * all + first, count);
        A.noalias() += x.transpose() * x;
        b.noalias() += x.transpose() * residual[s](i, k);
        energy += residual[s](i, k) * residual[s](i, k);
      }
  if (!(energy > 0.0)) return 0.0;
  A.diagonal().array() += kPolicy.locate.ridge * A.trace() + kPolicy.locate.least_ridge;
  return std::clamp(b.dot(A.ldlt().solve(b)) / energy, 0.0, 1.0);
}

}  // namespace leeway::gap
