#pragma once

#include <Eigen/Core>

#include "dynamics/coefficient_law.hpp"

namespace leeway::gap {

/// What is believed of theta before any recording is seen: normal, with mean 0. Coefficients may go together, as the
/// ship's file states; coordinates of effects and the timing are independent of them and of each other.
class ThetaPrior {
 public:
  ThetaPrior() = default;
  /// Each independent of the others.
  explicit ThetaPrior(const Eigen::VectorXd& sd);
  /// The coefficients' law, and the timing after them.
  ThetaPrior(const CoefficientLaw& law, double timing_sd);

  Eigen::Index size() const { return sd_.size(); }
  const Eigen::VectorXd& sd() const { return sd_; }  ///< of each by itself
  const Eigen::MatrixXd& precision() const { return precision_; }
  double log_determinant() const { return log_determinant_; }  ///< of the covariance
  /// ln of its density at theta, but for (2 pi)^(-size/2).
  double log_density(const Eigen::VectorXd& theta) const;
  /// precision * theta: what draws theta back to 0.
  Eigen::VectorXd pull(const Eigen::VectorXd& theta) const { return precision_ * theta; }

  /// Of a column of the precision, the places that are not 0.
  std::vector<Eigen::Index> linked(Eigen::Index column) const;

  /// The first `count` as many times as uncertain.
  ThetaPrior scaled(Eigen::Index count, double times) const;
  /// Independent ones inserted from a place on.
  ThetaPrior with(Eigen::Index place, const Eigen::VectorXd& sd) const;
  /// Some taken away that are independent of all others.
  ThetaPrior without(Eigen::Index place, Eigen::Index count) const;
  /// One is uncertain by `sd`, which is more than it was: what is added is its own.
  void widen(Eigen::Index place, double sd);
  /// One is measured as 0, with this sd: what goes with it is known better then as well.
  void hold(Eigen::Index place, double sd);

 private:
  Eigen::VectorXd sd_;
  Eigen::MatrixXd precision_;
  double log_determinant_ = 0.0;
};

}  // namespace leeway::gap
