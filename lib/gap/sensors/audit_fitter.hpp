#pragma once

#include <array>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "core/random.hpp"
#include "gap/sensors/kinematic_windows.hpp"
#include "gap/sensors/sensor_faults.hpp"

namespace leeway::gap {

/// Level of the residuals of one kind and the correlation of neighbors: negative where the noise of the pose that they
/// share prevails (a moving average), positive where the noise lasts (autoregressive).
struct WindowNoise {
  double sd = 1.0, rho = 0.0;
};
using KinematicNoise = std::array<WindowNoise, 2>;  ///< by Kinematics

/// A fit of some faults of the library to the recordings.
struct FaultFit {
  std::vector<std::size_t> members;  ///< of the library
  Eigen::VectorXd numbers;           ///< of all members, one after the other
  Eigen::VectorXd residuals;
  Eigen::MatrixXd sensitivities;  ///< of the residuals to the numbers
  KinematicNoise noise;
  Eigen::VectorXd heldout;  ///< log-likelihood of each unit by the fit without it
};

/// Normal equations of some rows.
struct NormalEquations {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  explicit NormalEquations(Eigen::Index n) : A(Eigen::MatrixXd::Zero(n, n)), b(Eigen::VectorXd::Zero(n)) {}
  void add(const Eigen::Ref<const Eigen::VectorXd>& j, double z, double weight);
  NormalEquations& operator+=(const NormalEquations& other);
  NormalEquations& operator-=(const NormalEquations& other);
};

/// Rows that are white and of unit variance, with Huber's weights.
struct WhitenedRows {
  Eigen::VectorXd z, weights;
  Eigen::VectorXd log_sd;  ///< of what each row was divided by
  Eigen::MatrixXd J;
};

/// Fits faults to the residuals of kinematic windows: Gauss-Newton, weighted after Huber, with the noise estimated
/// along the way.
class FaultFitter {
 public:
  explicit FaultFitter(const KinematicWindows& windows);

  /// No fault.
  FaultFit sound() const;
  /// The members of `base` with one more, all numbers fitted anew; latencies are searched over their whole range.
  FaultFit with(const FaultFit& base, std::size_t candidate) const;
  /// The same members but for the one at `place`.
  FaultFit without(const FaultFit& base, std::size_t place) const;

  const KinematicWindows& windows() const { return windows_; }
  /// The unit of resampling that a row of residuals belongs to.
  std::size_t unit(Eigen::Index row) const { return unit_of_row_[static_cast<std::size_t>(row)]; }
  /// How many numbers a member of the library has.
  static Eigen::Index size_of(std::size_t member);
  Eigen::VectorXd own_numbers(const FaultFit& fit, std::size_t place) const;
  Eigen::VectorXd prior_precision(const std::vector<std::size_t>& members) const;
  /// Residuals and sensitivities of a fit, whitened with `noise`.
  WhitenedRows whitened(const FaultFit& fit, const KinematicNoise& noise) const;

  /// What the last member does to the residuals, a column for each of its numbers: slopes at the fit; of latencies and
  /// lags the mean slope from as much early to as much late. Channels that are shifted bring their own noise along,
  /// which is in the residuals as well: of slopes that are as much before as after, its mean product with them is zero.
  Eigen::MatrixXd actions_of_last(const FaultFit& fit) const;

  /// Standard deviations of functions of the numbers, by drawing units with replacement.
  ///   derive  maps the numbers of a draw to what the deviation is wanted of
  Eigen::VectorXd resampled_sd(const FaultFit& fit, RandomStream stream,
                               const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& derive) const;

 private:
  WindowNoise estimate_noise(Kinematics kind, const Eigen::VectorXd& residuals, Eigen::Index parameters) const;
  KinematicNoise estimate_noise(const Eigen::VectorXd& residuals, Eigen::Index parameters) const;
  double correlation(Kinematics kind, const Eigen::VectorXd& residuals, double n, double rough_sd) const;
  double huber_level(Kinematics kind, Eigen::VectorXd residuals, double rho, double freedom, double rough_sd) const;
  double cost_of(Eigen::VectorXd residuals, const FaultFit& of, const KinematicNoise& noise) const;
  SensorFaults faults_of(const FaultFit& fit) const;
  Eigen::VectorXd chord(const FaultFit& fit, Eigen::Index column, const std::vector<FaultParameter>& number,
                        double from, double to) const;
  Eigen::MatrixXd sensitivities(const FaultFit& fit) const;
  void limit(FaultFit& fit) const;
  bool step(FaultFit& fit) const;
  FaultFit fitted(FaultFit start) const;
  std::array<double, 2> log_shrinking(const FaultFit& fit) const;
  void predict_left_out(FaultFit& fit) const;
  std::vector<NormalEquations> normals_by_unit(const WhitenedRows& rows) const;

  const KinematicWindows& windows_;
  std::vector<std::size_t> unit_of_row_;
};

}  // namespace leeway::gap
