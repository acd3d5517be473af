#include "gap/fit/events.hpp"

#include <algorithm>
#include <cmath>

#include "core/statistics.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {

Vec3<double> typical_acceleration(const std::vector<LinearStretch>& stretches) {
  Vec3<double> sum = Vec3<double>::Zero();
  double n = 0.0;
  for (const LinearStretch& stretch : stretches)
    for (std::size_t k = 0; k + 1 < stretch.path.size(); ++k) {
      const Vec3<double> rate = (stretch.path[k + 1] - stretch.path[k]).segment<3>(3) / stretch.data->dt_s(k);
      sum += rate.cwiseAbs2();
      n += 1.0;
    }
  return (sum / n).cwiseSqrt();
}

void find_events(FittedNull& fit, const Campaign& campaign) {
  fit.log_prior_of_events = 0.0;
  const double block_s = kPolicy.fit.event_block_s * campaign.time_scale();
  struct Piece {
    std::size_t stretch, begin, end;
    Vec3<double> mean_square;
  };
  std::vector<Piece> blocks;
  for (std::size_t s = 0; s < campaign.stretches.size(); ++s) {
    const Stretch& stretch = campaign.stretches[s];
    const Smoothed& smoothed = fit.smoothed[s];
    fit.event_scale[s].resize(stretch.size(), Vec3<double>::Ones());
    for (std::size_t begin = 0, end = 0; begin < stretch.size(); begin = end) {
      Vec3<double> square = Vec3<double>::Zero();
      for (; end < stretch.size() && stretch.t_s[end] - stretch.t_s[begin] < block_s; ++end)
        square += smoothed.state[end].segment<3>(kErrorStart).cwiseAbs2() +
                  smoothed.covariance[end].diagonal().segment<3>(kErrorStart);
      blocks.push_back({s, begin, end, square / static_cast<double>(end - begin)});
    }
  }
  std::vector<double> squares(blocks.size());
  for (int i = 0; i < 3; ++i) {
    std::transform(blocks.begin(), blocks.end(), squares.begin(), [i](const Piece& b) { return b.mean_square[i]; });
    const double usual = median(squares) / kPolicy.fit.median_square;
    for (const Piece& block : blocks) {
      const double ratio = block.mean_square[i] / usual;
      const bool was_event = fit.event_scale[block.stretch][block.begin][i] > 1.0;
      const double scale = ratio > (was_event ? kPolicy.fit.still_event : kPolicy.fit.event) ? std::sqrt(ratio) : 1.0;
      if (scale > 1.0) fit.log_prior_of_events -= std::log(static_cast<double>(kAxisNames.size() * blocks.size()));
      for (std::size_t k = block.begin; k < block.end; ++k) fit.event_scale[block.stretch][k][i] = scale;
    }
  }
}

std::vector<std::shared_ptr<const Stretch>> without_outliers(FittedNull& fit) {
  struct Judgment {
    std::size_t stretch, point;
    double z;
  };
  std::vector<std::shared_ptr<Stretch>> judged(fit.stretches.size());  // those with outliers
  for (int i = 0; i < kShipStates; ++i) {
    const double R = std::pow(fit.noise.measurement_sd[i], 2);
    std::vector<Judgment> judgments;
    std::vector<double> scores;
    for (std::size_t s = 0; s < fit.stretches.size(); ++s) {
      const LinearStretch& stretch = fit.stretches[s];
      for (std::size_t k = 1; k < stretch.path.size(); ++k) {
        const double y = fit.stretches[s].data->measured[k][i];
        const double left = R - fit.smoothed[s].covariance[k](i, i);
        // Where others say little about it, left is rounding.
        if (std::isnan(y) || left < kPolicy.fit.least_left * R) continue;
        const double e = y - stretch.mean_offset[k][i] - fit.smoothed[s].state[k][i];
        judgments.push_back({s, k, e / std::sqrt(left)});
        scores.push_back(judgments.back().z);
      }
    }
    const double sd = std::clamp(robust_sd(std::move(scores)), kPolicy.fit.least_robust_sd, 1.0);
    for (const Judgment& judgment : judgments)
      if (std::abs(judgment.z) > kPolicy.fit.outlier_sd * sd) {
        std::shared_ptr<Stretch>& stretch = judged[judgment.stretch];
        if (!stretch) stretch = std::make_shared<Stretch>(*fit.stretches[judgment.stretch].data);
        stretch->measured[judgment.point][i] = kMissing;
        ++fit.report.outliers;
      }
  }
  return {judged.begin(), judged.end()};
}

}  // namespace leeway::gap
