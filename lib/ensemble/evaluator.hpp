#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ensemble/member.hpp"
#include "ensemble/model_files.hpp"
#include "recording/samples.hpp"

namespace leeway::ensemble {

/// A trained ensemble, ready to evaluate.
class Ensemble {
 public:
  /// Reads ensemble.json and the first `use_members` members (0: all). Throws InputError or IoError.
  Ensemble(const std::string& folder, int use_members, const nn::Kernels<float>& kernels);
  Ensemble(EnsembleHeader header, std::vector<Member> members, const nn::Kernels<float>& kernels,
           std::shared_ptr<const BaseModel> base = nullptr,
           std::vector<std::shared_ptr<const BaseModel>> own_bases = {});

  const EnsembleHeader& header() const { return header_; }
  int members() const { return static_cast<int>(members_.size()); }
  const BaseModel* base() const { return base_.get(); }  ///< nullptr where there is none
  /// That of a member: its own draw, or the one of all.
  const BaseModel* base(int member) const {
    const auto& own = own_bases_[static_cast<std::size_t>(member)];
    return own ? own.get() : base_.get();
  }
  const Member& member(int number) const { return members_[static_cast<std::size_t>(number)]; }
  const nn::Kernels<float>& kernels() const { return *kernels_; }
  /// What the user should know: members of kernels that give different bits.
  std::vector<std::string> notices() const;
  const RolloutConstants<float>& constants(int member) const { return *constants_[static_cast<std::size_t>(member)]; }
  const void* dynamics(int member) const { return dynamics_[static_cast<std::size_t>(member)].get(); }
  const void* initial_state(int member) const { return initial_state_[static_cast<std::size_t>(member)].get(); }

 private:
  void prepare(const Member& member);

  EnsembleHeader header_;
  const nn::Kernels<float>* kernels_;
  std::shared_ptr<const BaseModel> base_;
  std::vector<std::shared_ptr<const BaseModel>> own_bases_;  ///< one for each member; nullptr: base_
  std::vector<Member> members_;
  std::vector<std::unique_ptr<RolloutConstants<float>>> constants_;
  std::vector<nn::PackedNetwork<float>> dynamics_, initial_state_;
};

/// Evaluates members for one thread.
class EnsembleEvaluator {
 public:
  explicit EnsembleEvaluator(const Ensemble& ensemble);

  /// (u', v_m' [m/s^2], r' [rad/s^2]) of one member's network for states side by side; where there is a base model,
  /// what comes on top of it. `actuators` and `true_wind` have one column for all states, or one for each.
  ///   eta (x0, y0 [m], psi [rad]); nu (u, v_m [m/s], r [rad/s]); actuators in the order of
  ///   header().inputs.sampled_actuators()
  Eigen::Matrix3Xd accelerations(int member, const Eigen::Matrix3Xd& eta, const Eigen::Matrix3Xd& nu,
                                 const Eigen::Ref<const Eigen::MatrixXd>& actuators,
                                 const Eigen::Ref<const Eigen::Matrix2Xd>& true_wind);

  /// One step of the equations of motion with the inputs held. A state's numbers do not depend on those beside it. With
  /// a base model Euler is the step of the training: the network's part by Euler, that of the base by Runge-Kutta.
  ///   t_s  at the step's start, for a base model with effects that change with time: one for all, or one for each
  void step(int member, Integrator integrator, double dt_s, const Eigen::Ref<const Eigen::MatrixXd>& actuators,
            const Eigen::Ref<const Eigen::Matrix2Xd>& true_wind, Eigen::Matrix3Xd& eta, Eigen::Matrix3Xd& nu,
            const Eigen::Ref<const Eigen::RowVectorXd>& t_s = Eigen::RowVectorXd::Zero(1));

  /// The member's estimate of the state at the range's first point from its first initial_state_steps observations;
  /// the observed state where there is no initial-state network or the range is shorter.
  void estimate_initial_state(int member, const Samples& samples, Range range, Vec3<double>& eta, Vec3<double>& nu);

 private:
  const Ensemble* ensemble_;
  nn::KernelWorkspace<float> workspace_;
  nn::AlignedVector<float> inputs_, accelerations_;
};

/// Velocities of the pose, eta' = R(psi) nu, of states side by side.
Eigen::Matrix3Xd pose_rates(const Eigen::Matrix3Xd& eta, const Eigen::Matrix3Xd& nu);

}  // namespace leeway::ensemble
