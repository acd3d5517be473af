#include "gap/fit/events.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/statistics.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

struct EventBlock {
  std::size_t stretch, begin, end;  // points
};

std::vector<EventBlock> blocks_of_events(const Campaign& campaign) {
  const double block_s = kPolicy.fit.event_block_s * campaign.time_scale();
  std::vector<EventBlock> blocks;
  for (std::size_t s = 0; s < campaign.stretches.size(); ++s) {
    const Stretch& stretch = campaign.stretches[s];
    for (std::size_t begin = 0, end = 0; begin < stretch.size(); begin = end) {
      while (end < stretch.size() && stretch.t_s[end] - stretch.t_s[begin] < block_s) ++end;
      blocks.push_back({s, begin, end});
    }
  }
  return blocks;
}

}  // namespace

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
  const std::vector<EventBlock> blocks = blocks_of_events(campaign);
  for (std::size_t s = 0; s < campaign.stretches.size(); ++s)
    fit.event_scale[s].resize(campaign.stretches[s].size(), Vec3<double>::Ones());
  std::vector<Vec3<double>> mean_squares;
  for (const EventBlock& block : blocks) {
    const Smoothed& smoothed = fit.smoothed[block.stretch];
    Vec3<double> square = Vec3<double>::Zero();
    for (std::size_t k = block.begin; k < block.end; ++k)
      square += smoothed.state[k].segment<3>(kErrorStart).cwiseAbs2() +
                smoothed.covariance[k].diagonal().segment<3>(kErrorStart);
    mean_squares.emplace_back(square / static_cast<double>(block.end - block.begin));
  }
  std::vector<double> squares(blocks.size());
  for (Eigen::Index i = 0; i < 3; ++i) {
    std::ranges::transform(mean_squares, squares.begin(), [i](const Vec3<double>& square) { return square[i]; });
    const double usual = median(squares) / kPolicy.fit.median_square;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      std::vector<Vec3<double>>& scales = fit.event_scale[blocks[b].stretch];
      const double ratio = mean_squares[b][i] / usual;
      const bool was_event = scales[blocks[b].begin][i] > 1.0;
      const double scale = ratio > (was_event ? kPolicy.fit.still_event : kPolicy.fit.event) ? std::sqrt(ratio) : 1.0;
      for (std::size_t k = blocks[b].begin; k < blocks[b].end; ++k) scales[k][i] = scale;
    }
  }
  fit.log_prior_of_events = 0.0;
  for (const Event& event : events_of(fit, campaign)) fit.log_prior_of_events += event.log_prior;
}

std::vector<Event> events_of(const FittedNull& fit, const Campaign& campaign) {
  const std::vector<EventBlock> blocks = blocks_of_events(campaign);
  const double begins = -std::log(static_cast<double>(kAxisNames.size() * blocks.size()));
  std::vector<Event> events;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    bool goes_on = false;
    for (const EventBlock& block : blocks) {
      const std::vector<Vec3<double>>& scales = fit.event_scale[block.stretch];
      const bool acts = !scales.empty() && scales[block.begin][axis] > 1.0;
      if (acts && !(goes_on && events.back().stretch == block.stretch))
        events.push_back({block.stretch, block.begin, block.end, axis, begins});
      if (acts) {
        events.back().end = block.end;
        events.back().log_prior -= std::numbers::ln2;
      }
      goes_on = acts;
    }
  }
  return events;
}

void leave_out(const Event& event, FittedNull& fit) {
  for (std::size_t k = event.begin; k < event.end; ++k) fit.event_scale[event.stretch][k][event.axis] = 1.0;
  fit.log_prior_of_events -= event.log_prior;
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
