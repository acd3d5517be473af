#include "gap/fit/theta_prior.hpp"

#include <cmath>
#include <vector>

#include "core/linear_algebra.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

ThetaPrior::ThetaPrior(const Eigen::VectorXd& sd)
    : sd_(sd),
      precision_(sd.array().square().inverse().matrix().asDiagonal()),
      log_determinant_(2.0 * sd.array().log().sum()) {}

ThetaPrior::ThetaPrior(const CoefficientLaw& law, double timing_sd) {
  const Eigen::Index n = law.covariance.rows();
  Eigen::MatrixXd covariance = law.covariance;
  covariance.diagonal() *= 1.0 + kPolicy.fit.least_own_variance;  // a file may state that one follows from others
  const Eigen::LLT<Eigen::MatrixXd> factors(covariance);
  sd_.resize(n + 1);
  sd_ << covariance.diagonal().cwiseSqrt(), timing_sd;
  precision_ = Eigen::MatrixXd::Zero(n + 1, n + 1);
  precision_.topLeftCorner(n, n) = factors.solve(Eigen::MatrixXd::Identity(n, n));
  precision_(n, n) = 1.0 / (timing_sd * timing_sd);
  log_determinant_ = 2.0 * (factors.matrixLLT().diagonal().array().log().sum() + std::log(timing_sd));
}

double ThetaPrior::log_density(const Eigen::VectorXd& theta) const {
  return -0.5 * (theta.dot(pull(theta)) + log_determinant_);
}

std::vector<Eigen::Index> ThetaPrior::linked(Eigen::Index column) const {
  std::vector<Eigen::Index> places;
  for (Eigen::Index i = 0; i < size(); ++i)
    if (precision_(i, column) != 0.0) places.push_back(i);
  return places;
}

ThetaPrior ThetaPrior::scaled(Eigen::Index count, double times) const {
  ThetaPrior result = *this;
  result.sd_.head(count) *= times;
  result.precision_.topLeftCorner(count, count) /= times * times;
  result.log_determinant_ += 2.0 * static_cast<double>(count) * std::log(times);
  return result;
}

ThetaPrior ThetaPrior::with(Eigen::Index place, const Eigen::VectorXd& sd) const {
  const Eigen::Index count = sd.size(), rest = size() - place;
  ThetaPrior result;
  result.sd_.resize(size() + count);
  result.sd_ << sd_.head(place), sd, sd_.tail(rest);
  result.precision_ = Eigen::MatrixXd::Zero(size() + count, size() + count);
  result.precision_.topLeftCorner(place, place) = precision_.topLeftCorner(place, place);
  result.precision_.bottomRightCorner(rest, rest) = precision_.bottomRightCorner(rest, rest);
  result.precision_.topRightCorner(place, rest) = precision_.topRightCorner(place, rest);
  result.precision_.bottomLeftCorner(rest, place) = precision_.bottomLeftCorner(rest, place);
  result.precision_.diagonal().segment(place, count) = sd.array().square().inverse();
  result.log_determinant_ = log_determinant_ + 2.0 * sd.array().log().sum();
  return result;
}

ThetaPrior ThetaPrior::without(Eigen::Index place, Eigen::Index count) const {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < size(); ++i)
    if (i < place || i >= place + count) kept.push_back(i);
  ThetaPrior result;
  result.sd_ = sd_(kept);
  result.precision_ = precision_(kept, kept);
  result.log_determinant_ = log_determinant_ - 2.0 * sd_.segment(place, count).array().log().sum();
  return result;
}

// Sherman & Morrison: the covariance grows by one element of its diagonal.
void ThetaPrior::widen(Eigen::Index place, double sd) {
  const double added = sd * sd - sd_[place] * sd_[place];
  if (!(added > 0.0)) return;
  const double grown = 1.0 + added * precision_(place, place);
  const Eigen::VectorXd column = precision_.col(place);
  const std::vector<Eigen::Index> places = linked(place);
  for (const Eigen::Index i : places)
    for (const Eigen::Index j : places) precision_(i, j) -= added / grown * column[i] * column[j];
  log_determinant_ += std::log(grown);
  sd_[place] = sd;
}

void ThetaPrior::hold(Eigen::Index place, double sd) {
  precision_(place, place) += 1.0 / (sd * sd);
  const Eigen::LLT<Eigen::MatrixXd> factors(precision_);
  sd_ = factors.solve(Eigen::MatrixXd::Identity(size(), size())).diagonal().cwiseSqrt();
  log_determinant_ = -2.0 * factors.matrixLLT().diagonal().array().log().sum();
}

}  // namespace leeway::gap
