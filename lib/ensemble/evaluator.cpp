#include "ensemble/evaluator.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "core/wind.hpp"

namespace leeway::ensemble {
namespace {

// The column that belongs to state i: there is one for all, or one for each.
template <typename Matrix>
Eigen::Index column_of(const Matrix& matrix, Eigen::Index i) {
  return matrix.cols() == 1 ? 0 : i;
}

// The base model for states side by side over a step with held inputs.
class HeldBase {
 public:
  HeldBase(const BaseModel& base, const std::vector<Channel>& channels,
           const Eigen::Ref<const Eigen::MatrixXd>& actuators, const Eigen::Ref<const Eigen::Matrix2Xd>& true_wind,
           const Eigen::Ref<const Eigen::RowVectorXd>& t_s)
      : base_(base) {
    const Eigen::Index n = std::max({actuators.cols(), true_wind.cols(), t_s.cols()});
    for (Eigen::Index i = 0; i < n; ++i) {
      Inputs<double> in{{}, true_wind.col(column_of(true_wind, i)), t_s(column_of(t_s, i))};
      for (std::size_t a = 0; a < channels.size(); ++a)
        in.actuators[channels[a]] = actuators(static_cast<Eigen::Index>(a), column_of(actuators, i));
      inputs_.push_back(in);
      acting_.emplace_back(in.actuators);
    }
  }

  // The state after the step without the network.
  ShipState<double> step(Eigen::Index i, const ShipState<double>& state, double dt_s) const {
    return base_.step(state, inputs_[column(i)], dt_s);
  }

  // Adds the velocity of the water, or takes it off, `h` after the start.
  void add_water(double sign, double h, const Eigen::Matrix3Xd& eta, Eigen::Matrix3Xd& nu) const {
    if (!base_.model().moves_water()) return;
    for (Eigen::Index i = 0; i < nu.cols(); ++i)
      nu.col(i) += sign * water_velocity<double>(base_.model(), eta.col(i), inputs_[column(i)].t_s + h);
  }

  // Rates of the pose, and of the velocity through the water: those of the base, and `network` on top.
  void rates(double h, const Eigen::Matrix3Xd& eta, const Eigen::Matrix3Xd& nu_water, const Eigen::Matrix3Xd& network,
             Eigen::Matrix3Xd& pose, Eigen::Matrix3Xd& rate) const {
    pose.resize(3, eta.cols());
    rate.resize(3, eta.cols());
    for (Eigen::Index i = 0; i < eta.cols(); ++i) {
      Inputs<double> now = inputs_[column(i)];
      now.t_s += h;
      const ShipState<double> state{eta.col(i), nu_water.col(i)};
      const ShipState<double> change = rate_of_change(base_.model(), state, now, acting_[column(i)]);
      pose.col(i) = change.eta;
      rate.col(i) = change.nu + network.col(i);
    }
  }

 private:
  std::size_t column(Eigen::Index i) const { return inputs_.size() == 1 ? 0 : static_cast<std::size_t>(i); }

  const BaseModel& base_;
  std::vector<Inputs<double>> inputs_;
  std::vector<ActingActuators<double>> acting_;
};

}  // namespace

Eigen::Matrix3Xd pose_rates(const Eigen::Matrix3Xd& eta, const Eigen::Matrix3Xd& nu) {
  const Eigen::Array<double, 1, Eigen::Dynamic> c = eta.row(2).array().cos(), s = eta.row(2).array().sin();
  Eigen::Matrix3Xd rates(3, eta.cols());
  rates.row(0) = nu.row(0).array() * c - nu.row(1).array() * s;
  rates.row(1) = nu.row(0).array() * s + nu.row(1).array() * c;
  rates.row(2) = nu.row(2);
  return rates;
}

Ensemble::Ensemble(EnsembleHeader header, std::vector<Member> members, const nn::Kernels<float>& kernels,
                   std::shared_ptr<const BaseModel> base, std::vector<std::shared_ptr<const BaseModel>> own_bases)
    : header_(std::move(header)),
      kernels_(&kernels),
      base_(std::move(base)),
      own_bases_(std::move(own_bases)),
      members_(std::move(members)) {
  own_bases_.resize(members_.size());
  for (const Member& member : members_) prepare(member);
}

Ensemble::Ensemble(const std::string& folder, int use_members, const nn::Kernels<float>& kernels)
    : Ensemble(*read_header(folder), {}, kernels) {
  base_ = read_base(folder, header_);
  const int available = header_.config.members;
  if (use_members > available)
    throw UsageError(fmt::format("--use-members {}: {} has {} members", use_members, folder, available));
  const int n = use_members > 0 ? use_members : available;
  for (int k = 0; k < n; ++k) {
    if (!member_exists(folder, k))
      throw IoError(
          member_path(folder, k),
          fmt::format("is not trained yet; run ens-train with --member {} or --resume, or use --use-members", k));
    members_.push_back(read_member(folder, k, header_));
    own_bases_.push_back(read_own_base(folder, members_.back()));
    prepare(members_.back());
  }
}

void Ensemble::prepare(const Member& member) {
  constants_.push_back(std::make_unique<RolloutConstants<float>>(header_.inputs, header_.config, member));
  const float* parameters = member.parameters.data();
  dynamics_.emplace_back(*kernels_, member.dynamics, parameters);
  initial_state_.emplace_back(*kernels_, member.initial_state, parameters + nn::parameter_count(member.dynamics));
}

std::vector<std::string> Ensemble::notices() const {
  std::set<std::string> names;
  for (const Member& member : members_) names.insert(member.kernel);
  std::vector<std::string> notices;
  const auto as_first = [&](const std::string& name) { return nn::give_same_bits(*names.begin(), name); };
  if (!std::all_of(names.begin(), names.end(), as_first))
    notices.push_back(fmt::format(
        "the members were trained on different kernels ({}): a training on one of them gives others in the last digits",
        fmt::join(names, ", ")));
  if (!header_.is_hashed)
    notices.push_back("a model of an earlier version has no hashes: damaged weights would not be noticed");
  return notices;
}

EnsembleEvaluator::EnsembleEvaluator(const Ensemble& ensemble) : ensemble_(&ensemble), workspace_(ensemble.kernels()) {}

Eigen::Matrix3Xd EnsembleEvaluator::accelerations(int member, const Eigen::Matrix3Xd& eta, const Eigen::Matrix3Xd& nu,
                                                  const Eigen::Ref<const Eigen::MatrixXd>& actuators,
                                                  const Eigen::Ref<const Eigen::Matrix2Xd>& true_wind) {
  const ModelInputs& inputs = ensemble_->header().inputs;
  const Eigen::Index n = nu.cols(), width = static_cast<Eigen::Index>(inputs.inputs.size());
  inputs_.resize(static_cast<std::size_t>(n * width));
  accelerations_.resize(static_cast<std::size_t>(3 * n));
  float* x = inputs_.data();
  for (Eigen::Index i = 0; i < n; ++i) {
    for (int j = 0; j < 3; ++j) *x++ = static_cast<float>(nu(j, i));
    const Eigen::Index a = column_of(actuators, i);
    for (std::size_t j = 0; j < inputs.actuators.size(); ++j)
      *x++ = static_cast<float>(actuators(static_cast<Eigen::Index>(j), a));
    if (inputs.wind) {
      const Vec2<double> wind =
          apparent_wind<double>(true_wind.col(column_of(true_wind, i)), eta(2, i), nu(0, i), nu(1, i));
      *x++ = static_cast<float>(wind(0));
      *x++ = static_cast<float>(wind(1));
    }
  }
  ensemble_->kernels().accelerations(workspace_.get(), ensemble_->constants(member).view(), ensemble_->dynamics(member),
                                     inputs_.data(), static_cast<int>(n), accelerations_.data());
  return Eigen::Map<const Eigen::Matrix3Xf>(accelerations_.data(), 3, n).cast<double>();
}

void EnsembleEvaluator::step(int member, Integrator integrator, double dt_s,
                             const Eigen::Ref<const Eigen::MatrixXd>& actuators,
                             const Eigen::Ref<const Eigen::Matrix2Xd>& true_wind, Eigen::Matrix3Xd& eta,
                             Eigen::Matrix3Xd& nu, const Eigen::Ref<const Eigen::RowVectorXd>& t_s) {
  std::optional<HeldBase> base;
  if (ensemble_->base(member) != nullptr)
    base.emplace(*ensemble_->base(member), ensemble_->header().inputs.sampled_actuators(), actuators, true_wind, t_s);
  if (base && integrator == Integrator::euler) {
    const Eigen::Matrix3Xd network = accelerations(member, eta, nu, actuators, true_wind);
    for (Eigen::Index i = 0; i < nu.cols(); ++i) {
      const ShipState<double> end = base->step(i, {eta.col(i), nu.col(i)}, dt_s);
      eta.col(i) = end.eta;
      nu.col(i) = end.nu + dt_s * network.col(i);
    }
    return;
  }
  // The state of a base model in moving water is that through the water, as in integrate().
  if (base) base->add_water(-1.0, 0.0, eta, nu);
  const auto rates = [&](double h, const Eigen::Matrix3Xd& e, const Eigen::Matrix3Xd& v, Eigen::Matrix3Xd& pose,
                         Eigen::Matrix3Xd& rate) {
    if (base) {
      Eigen::Matrix3Xd over_ground = v;
      base->add_water(1.0, h, e, over_ground);
      base->rates(h, e, v, accelerations(member, e, over_ground, actuators, true_wind), pose, rate);
    } else {
      pose = pose_rates(e, v);
      rate = accelerations(member, e, v, actuators, true_wind);
    }
  };
  Eigen::Matrix3Xd pose1, rate1, pose2, rate2, pose3, rate3, pose4, rate4;
  rates(0.0, eta, nu, pose1, rate1);
  if (integrator == Integrator::euler) {
    eta += dt_s * pose1;
    nu += dt_s * rate1;
    return;
  }
  const auto stage = [&](double h, const Eigen::Matrix3Xd& pose, const Eigen::Matrix3Xd& rate,
                         Eigen::Matrix3Xd& next_pose, Eigen::Matrix3Xd& next_rate) {
    rates(h, eta + h * pose, nu + h * rate, next_pose, next_rate);
  };
  stage(0.5 * dt_s, pose1, rate1, pose2, rate2);
  stage(0.5 * dt_s, pose2, rate2, pose3, rate3);
  stage(dt_s, pose3, rate3, pose4, rate4);
  eta += dt_s / 6.0 * (pose1 + 2.0 * pose2 + 2.0 * pose3 + pose4);
  nu += dt_s / 6.0 * (rate1 + 2.0 * rate2 + 2.0 * rate3 + rate4);
  if (base) base->add_water(1.0, dt_s, eta, nu);
}

void EnsembleEvaluator::estimate_initial_state(int member, const Samples& samples, Range range, Vec3<double>& eta,
                                               Vec3<double>& nu) {
  eta = samples.eta.col(range.begin);
  nu = samples.nu.col(range.begin);
  const EnsembleHeader& header = ensemble_->header();
  if (!header.config.initial_state_net || range.size < header.config.initial_state_steps) return;
  const std::vector<double> observations = initial_state_observations(samples, range, header.config.initial_state_steps,
                                                                      header.inputs.pose_in_initial_state);
  inputs_.clear();
  for (std::size_t j = 0; j < observations.size(); ++j)
    inputs_.push_back(static_cast<float>((observations[j] - header.inputs.initial_state[j].mean) /
                                         header.inputs.initial_state[j].sd));
  float correction[6];
  ensemble_->kernels().forward(workspace_.get(), ensemble_->initial_state(member), inputs_.data(), 1, correction);
  // The correction of the position is in the ship axes of the first observation.
  const Vec3<double>& pose = header.config.pose_scale;
  const double dx = pose(0) * correction[0], dy = pose(1) * correction[1], c = std::cos(eta(2)), s = std::sin(eta(2));
  eta += Vec3<double>(c * dx - s * dy, s * dx + c * dy, pose(2) * correction[2]);
  for (int i = 0; i < 3; ++i) nu(i) += header.config.sigma(i) * correction[3 + i];
}

}  // namespace leeway::ensemble
