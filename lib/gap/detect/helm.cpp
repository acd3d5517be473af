#include "gap/detect/helm.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/linear_algebra.hpp"
#include "gap/detect/effect_library.hpp"

namespace leeway::gap {
namespace {

// The mean angle of all rudders; NaN where it is not known, or there are none.
double rudder_angle(const RecordedInputs& inputs, double t_s) {
  const Actuators<double> actuators = inputs.at(t_s).actuators;
  double sum = 0.0, rudders = 0.0;
  for (const Channel channel : inputs.channels())
    if (info(channel).role == Role::rudder) sum += actuators[channel], rudders += 1.0;
  return sum / rudders;
}

std::vector<double> rudder_angles(const Campaign& campaign, const Stretch& stretch) {
  std::vector<double> result;
  for (const double t_s : stretch.t_s) result.push_back(rudder_angle(campaign.recorded_inputs[stretch.recording], t_s));
  return result;
}

// Whether rudders that move between these angles hardly move.
bool stay(double least, double most) { return most - least < 4.0 * kKnownAngle; }

// Whether the rudders oppose a turn that goes on while the ship sails her length. Else they make it: in a long turn the
// yaw rate follows the rudders as closely as a helmsman's rudders follow it.
bool opposes(const HelmLaw& law, const Ship& ship, const Smoothed& smoothed) {
  double speed = 0.0;
  for (const StateVector& x : smoothed.state)
    speed += x.segment<2>(3).norm() / static_cast<double>(smoothed.state.size());
  return law.per_heading * ship.particulars.L_pp + law.per_rate_s * speed < 0.0;
}

}  // namespace

std::optional<Helm> helm_of(const Campaign& campaign, const Stretch& stretch, const Smoothed& smoothed) {
  const std::vector<double> angle = rudder_angles(campaign, stretch);
  if (angle.empty() || std::ranges::any_of(angle, [](double x) { return std::isnan(x); })) return std::nullopt;
  const auto [least, most] = std::ranges::minmax(angle);
  std::vector<std::size_t> free;  // points at which the rudders are at no limit, where they follow nothing
  for (std::size_t k = 0; k < angle.size(); ++k)
    if (angle[k] > least + kKnownAngle && angle[k] < most - kKnownAngle) free.push_back(k);
  if (stay(least, most)) {  // they have no limits
    free.resize(angle.size());
    std::iota(free.begin(), free.end(), std::size_t{0});
  }
  if (2 * free.size() < angle.size()) return std::nullopt;

  const auto n = static_cast<Eigen::Index>(free.size());
  const bool has_heading =
      std::ranges::any_of(stretch.measured, [](const Vec6& measured) { return !std::isnan(measured[2]); });
  Eigen::MatrixXd X(n, has_heading ? 3 : 2);
  Eigen::VectorXd y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t k = free[static_cast<std::size_t>(i)];
    X(i, 0) = 1.0;
    X(i, 1) = smoothed.state[k][5];
    if (has_heading) X(i, 2) = smoothed.state[k][2];
    y[i] = angle[k];
  }
  if (n <= 2 * X.cols()) return std::nullopt;
  const Eigen::VectorXd law = X.colPivHouseholderQr().solve(y), beside = y - X * law;
  double unknown = 0.0;  // variance of what the rudders follow, as the sensors leave it
  for (const std::size_t k : free) {
    const StateMatrix& P = smoothed.covariance[k];
    unknown += law[1] * law[1] * P(5, 5);
    if (has_heading) unknown += law[2] * (law[2] * P(2, 2) + 2.0 * law[1] * P(2, 5));
  }
  unknown /= static_cast<double>(n);
  const double variance = beside.squaredNorm() / static_cast<double>(n);
  Helm helm;
  helm.law.offset = law[0];
  helm.law.per_rate_s = law[1];
  if (has_heading) helm.law.per_heading = law[2];
  helm.law.sd = std::sqrt(variance);
  for (const Channel channel : campaign.recorded_inputs[stretch.recording].channels())
    if (info(channel).role == Role::rudder) helm.law.rudders.push_back(channel);
  helm.law.angle.assign(angle.size(), kMissing);
  for (const std::size_t k : free) helm.law.angle[k] = angle[k];
  if (unknown > 0.0) helm.ahead = unknown / variance;
  return helm;
}

std::optional<Campaign> with_helms(const Campaign& campaign, const std::vector<Smoothed>& smoothed) {
  std::optional<Campaign> result;
  for (std::size_t s = 0; s < campaign.stretches.size(); ++s) {
    std::optional<Helm> helm = helm_of(campaign, campaign.stretches[s], smoothed[s]);
    if (!helm || !(helm->ahead > kPolicy.detect.helm_ahead) || !opposes(helm->law, campaign.ship, smoothed[s]))
      continue;
    if (!result) result = campaign;
    result->stretches[s].helm = std::move(helm->law);
  }
  return result;
}

bool is_straight(const Campaign& campaign, const Stretch& stretch, const Smoothed& smoothed) {
  const std::vector<double> angle = rudder_angles(campaign, stretch);
  if (angle.empty()) return true;
  const auto [least, most] = std::ranges::minmax(angle);
  if (!stay(least, most)) return false;
  return std::ranges::all_of(std::array{4, 5}, [&](int i) {
    double motion = 0.0, unknown = 0.0;
    for (std::size_t k = 0; k < smoothed.state.size(); ++k) {
      motion += smoothed.state[k][i] * smoothed.state[k][i];
      unknown += smoothed.covariance[k](i, i);
    }
    return motion <= kPolicy.detect.still_sds * kPolicy.detect.still_sds * unknown;
  });
}

}  // namespace leeway::gap
