#include "gap/fit/effect_columns.hpp"

namespace leeway::gap {

EffectSide::EffectSide(const Ship& ship, const Eigen::VectorXd& plain_theta, const RecordedInputs& recorded,
                       const RudderResponse& like)
    : model_(ship) {
  apply_uncertainty(model_, plain_theta);
  if (const RudderResponse& response = model_.rudder_response(); response != like) inputs_ = recorded.through(response);
}

Vec6 EffectSide::step(const LinearStretch& stretch, std::size_t k) const {
  const std::vector<StepInputs<double>>& own = stretch.data->inputs[k];
  const double h = stretch.data->dt_s(k) / static_cast<double>(own.size());
  if (!inputs_) return stretch.steps[k].answered(advance<double>(model_, stretch.path[k], own, h));
  std::vector<StepInputs<double>> inputs = own;
  for (std::size_t i = 0; i < inputs.size(); ++i)
    inputs[i] = averaged_step(*inputs_, stretch.data->t_s[k] + static_cast<double>(i) * h, h);
  return stretch.steps[k].answered(advance<double>(model_, stretch.path[k], inputs, h));
}

Vec6 EffectSide::push(const LinearStretch& stretch, std::size_t k) const {
  const std::vector<StepInputs<double>>& own = stretch.data->inputs[k];
  const Inputs<double>& middle = own[own.size() / 2].middle;
  const Vec6 first = stretch.path[k].head<kShipStates>(), last = stretch.path[k + 1].head<kShipStates>(),
             over_ground = 0.5 * (first + last);
  ShipState<double> at{over_ground.head<3>(), over_ground.tail<3>()};
  Vec3<double> by_water = Vec3<double>::Zero();
  if (model_.moves_water()) {
    at.nu -= water_velocity(model_, at.eta, middle.t_s);
    by_water = (water_velocity<double>(model_, last.head<3>(), own.back().end.t_s) -
                water_velocity<double>(model_, first.head<3>(), own.front().start.t_s)) /
               stretch.data->dt_s(k);
  }
  return stretch.steps[k].A.block<kShipStates, 3>(0, kErrorStart) * (rate_of_change(model_, at, middle).nu + by_water);
}

EffectColumns::EffectColumns(const Campaign& campaign, const Hypothesis& hypothesis, const Eigen::VectorXd& z,
                             const Eigen::VectorXd& plain_theta, std::size_t recording)
    : recorded_(campaign.recorded_inputs[recording]),
      ship_(hypothesis.applied_to(campaign.ship_in(recording), z, recording)),
      response_(rudder_response_of(ship_)) {
  Eigen::Index j = 0;
  const auto side_at = [&](double off) {
    const Eigen::VectorXd at = z + off * Eigen::VectorXd::Unit(z.size(), j);
    return EffectSide(hypothesis.applied_to(campaign.ship_in(recording), at, recording), plain_theta, recorded_,
                      response_);
  };
  for (const FreeEffect& effect : hypothesis.effects)
    for (const double difference : effect.differences()) {
      slopes_.emplace_back();
      if (effect.recording().value_or(recording) == recording) slopes_.back().emplace(side_at, difference);
      ++j;
    }
}

void EffectColumns::set_inputs_of(Stretch& stretch) const { set_inputs(stretch, recorded_.through(response_), ship_); }

void EffectColumns::add_to(LinearStretch& stretch) const {
  const auto count = static_cast<Eigen::Index>(slopes_.size());
  for (std::size_t k = 0; k < stretch.steps.size(); ++k) {
    ByRow<kShipStates>& G = stretch.steps[k].G;
    const Eigen::Index plain = G.cols() - 1;
    ByRow<kShipStates> wider(kShipStates, plain + count + 1);
    wider.leftCols(plain) = G.leftCols(plain);
    wider.rightCols(1) = G.rightCols(1);
    for (Eigen::Index j = 0; j < count; ++j) {
      if (const auto& slope = slopes_[static_cast<std::size_t>(j)])
        wider.col(plain + j) = slope->step(stretch, k);
      else
        wider.col(plain + j).setZero();
    }
    G = std::move(wider);
  }
}

Eigen::VectorXd without_effects(const Eigen::VectorXd& theta, Eigen::Index effects) {
  Eigen::VectorXd plain(theta.size() - effects);
  plain << theta.head(theta.size() - effects - 1), theta.tail(1);
  return plain;
}

}  // namespace leeway::gap
