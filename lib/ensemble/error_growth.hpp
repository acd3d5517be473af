#pragma once

#include <vector>

#include "core/types.hpp"

namespace leeway::ensemble {

/// Noises that make predictions miss, each with a variance: Ornstein-Uhlenbeck accelerations by axis (u, v_m, r) and
/// time constant, white noise of the sensors by axis, and what is open of the inputs between their samples (as a
/// whole).
struct Noises {
  /// Time constants from a step to a sequence of `steps` points, two a decade.
  Noises(double time_step_s, int steps);

  double time_step_s;
  std::vector<double> tau_s;

  std::size_t size() const { return 3 * tau_s.size() + 3; }
  std::size_t disturbance(std::size_t axis, std::size_t i) const { return axis * tau_s.size() + i; }
  std::size_t sensor(std::size_t axis) const { return 3 * tau_s.size() + axis; }
};

/// A step of a prediction: derivatives of its end (psi [rad], u, v_m [m/s], r [rad/s]) by its start, and by inputs that
/// move by all that is open of them (Samples).
struct StepDerivatives {
  Eigen::Matrix4d by_state = Eigen::Matrix4d::Zero();
  Eigen::Matrix4Xd by_input;
};

/// What a sequence's prediction misses, as means over blocks of ten points: (u, v_m, r) of the first block, then of the
/// next; and what is expected of it.
struct MissedBlocks {
  Eigen::VectorXd missed;
  Eigen::MatrixXd of_members;  ///< covariance by the networks that were averaged
  Eigen::MatrixXd of_inputs;   ///< by what is open of the inputs: in all steps the same share of each, uniform
  std::vector<Eigen::MatrixXd> by_unit;  ///< covariance by a unit of the variance of each noise
};

///   error     recorded - mean of the networks, from the second point on
///   networks  of each, by point: its velocities
///   steps     of the same points
MissedBlocks missed_blocks(const std::vector<Vec3<double>>& error, const std::vector<Eigen::Matrix3Xd>& networks,
                           const std::vector<StepDerivatives>& steps, const Noises& noises);

/// Variances v_i >= 0 of the noises with which what is missed is as large as expected, weighed by each noise:
///   sum of missed' W D_i W missed = sum of tr(W D_i W C),   C = of_members + of_inputs + sum of v_i D_i,
/// D_i = by_unit, W the inverse of the mean of C over the sequences. With the inverse of each C in place of W these are
/// the equations of the likelihood; but a covariance of few networks is known so badly that a sequence would seem to
/// miss more than it does. They are right in the mean whatever the law of what is missed, and solved by steps that keep
/// the variances positive, as those of Zhou, Hu, Zhou & Lange (2019), J. Comput. Graph. Stat. 28, 350-361.
///   all  at least one, of equal length
std::vector<double> noise_variances(const std::vector<MissedBlocks>& all, const Noises& noises);

}  // namespace leeway::ensemble
