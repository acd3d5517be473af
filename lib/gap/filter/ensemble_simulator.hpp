#pragma once

#include <string>
#include <vector>

#include "dynamics/simulation.hpp"
#include "ensemble/prediction.hpp"

namespace leeway::gap {

/// A trained ensemble in place of a ship's equations of motion.
class EnsembleSimulator {
 public:
  ///   name    for messages and reports
  ///   L_pp_m  length of the ship, by which times and yaw accelerations scale, where there is no base ship; 0: the one
  ///           whose time step in the ensemble paper would be the ensemble's, 3 m at 1 s, 147 m at 7 s
  EnsembleSimulator(ensemble::Ensemble ensemble, std::string name, double L_pp_m = 0.0);

  const std::string& name() const { return name_; }
  const ensemble::Ensemble& ensemble() const { return ensemble_; }
  double time_step_s() const { return ensemble_.header().config.time_step_s; }
  /// What is known of the ship: its name, its length and the actuators that the ensemble sees; with a base ship, that
  /// ship. It has a wind module if and only if the ensemble sees the wind.
  const Ship& ship() const { return ship_; }
  /// Whether accelerations can be stated as forces: by the base ship's inertia.
  bool knows_inertia() const { return ensemble_.base() != nullptr; }

  /// Throws InputError if the recording lacks a column that the ensemble needs, or is sampled more slowly than 1.5 time
  /// steps of the training.
  void check(const Trajectory& recording) const;

  /// How far each input of the networks lies beyond its range in the training data, by a tenth of the range's width; 0
  /// inside. In the order of header().inputs.domain; empty where the ensemble knows no domain.
  ///   nu  (u, v_m [m/s], r [rad/s]) over ground
  std::vector<double> beyond(double psi, const Vec3<double>& nu, const Inputs<double>& inputs) const;
  /// Standard deviation of the acceleration (m/s^2, m/s^2, rad/s^2) over the training data: what an ensemble that knows
  /// nothing errs by.
  Vec3<double> typical_acceleration() const;

 private:
  ensemble::Ensemble ensemble_;
  std::string name_;
  Ship ship_;
};

/// Steps of the ensemble: means over the members' steps of ens-predict. For one thread.
class EnsembleSteps {
 public:
  explicit EnsembleSteps(const EnsembleSimulator& simulator);

  struct Step {
    Eigen::Matrix<double, 6, 1> end;           ///< (x0, y0 [m], psi [rad], u, v_m [m/s], r [rad/s])
    Eigen::Matrix<double, 6, 11> derivatives;  ///< by the state
    Mat3<double> spread;                       ///< covariance of the members' accelerations, mean over the step
  };
  /// A step with accelerations and an error of the wind beside what is recorded, as gap::advance() takes it for a ship.
  /// Each substep holds the mean of its inputs, as in the training.
  ///   x       (x0, y0, psi, u, v_m, r, w_u, w_v, w_r, e_x, e_y), see state_space.hpp
  ///   inputs  what acts, in substeps of h_s
  Step step(const Eigen::Matrix<double, 11, 1>& x, const std::vector<StepInputs<double>>& inputs, double h_s);
  /// Where it leads alone.
  Eigen::Matrix<double, 6, 1> end(const Eigen::Matrix<double, 11, 1>& x, const std::vector<StepInputs<double>>& inputs,
                                  double h_s);

 private:
  Step advance(const Eigen::Matrix<double, 11, 1>& x, const std::vector<StepInputs<double>>& inputs, double h_s,
               bool with_derivatives);

  const EnsembleSimulator& simulator_;
  ensemble::EnsembleEvaluator evaluator_;
  std::vector<Channel> channels_;
};

}  // namespace leeway::gap
