#include "gap/detect/blocks.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
Evidence Blocks::total() const {
  Evidence sum(evidence.front().b.size());
  for (const Evidence& block : evidence) sum += block;
  return sum;
}

Blocks blocks_of(const Campaign& campaign, const FittedNull& fit, const Noise& noise, const ExtraColumns& extra,
                 std::size_t jobs) {
  return blocks_of(
      campaign, fit.stretches.size(),
      [&](std::size_t s, std::size_t points) {
        return evidence_by_blocks(fit.stretches[s], noise, points, extra.count, extra.of ? extra.of(s) : MoreColumns());
      },
      jobs);
}

Blocks blocks_of(const Campaign& campaign, std::size_t stretches,
                 const std::function<std::vector<Evidence>(std::size_t, std::size_t)>& evidence_of, std::size_t jobs) {
  Blocks blocks;
  blocks.points = static_cast<std::size_t>(std::ceil(kPolicy.detect.block_s * campaign.time_scale() /
                                                     std::max(campaign.step_s, kPolicy.detect.least_step_s)));
  std::vector<std::vector<Evidence>> parts(stretches);
  parallel_for(parts.size(), jobs, [&](std::size_t s) { parts[s] = evidence_of(s, blocks.points); });
  for (std::size_t s = 0; s < parts.size(); ++s)
    for (std::size_t i = 0; i < parts[s].size(); ++i) {
      blocks.evidence.push_back(std::move(parts[s][i]));
      blocks.stretch.push_back(s);
      blocks.begin.push_back(i * blocks.points);
    }
  return blocks;
}

double overdispersion(const Blocks& blocks, const Eigen::VectorXd& direction, const Eigen::VectorXd& fitted) {
  double seen = 0.0, expected = 0.0;
  for (const Evidence& block : blocks.evidence) {
    const double score = direction.dot(block.b - block.F * fitted);
    seen += score * score;
    expected += direction.dot(block.F * direction);
  }
  return std::max(1.0, expected > 0.0 ? seen / expected : 1.0);
}

std::vector<std::vector<std::size_t>> folds_of(const Campaign& campaign, const Blocks& blocks) {
  std::vector<std::size_t> recordings;
  for (const std::size_t s : blocks.stretch) recordings.push_back(campaign.stretches[s].recording);
  std::vector<std::size_t> different = recordings;
  different.erase(std::unique(different.begin(), different.end()), different.end());
  std::vector<std::vector<std::size_t>> folds;
  if (different.size() >= kPolicy.detect.least_recordings) {
    for (const std::size_t recording : different) {
      folds.emplace_back();
      for (std::size_t i = 0; i < recordings.size(); ++i)
        if (recordings[i] == recording) folds.back().push_back(i);
    }
  } else {
    const std::size_t n = recordings.size(), count = std::min(kPolicy.detect.most_folds, n);
    folds.resize(count);
    for (std::size_t i = 0; i < n; ++i) folds[i * count / n].push_back(i);
  }
  return folds;
}

Evidence without(const Evidence& total, const Blocks& blocks, const std::vector<std::size_t>& fold) {
  Evidence others = total;
  for (const std::size_t i : fold) {
    others.b -= blocks.evidence[i].b;
    others.F -= blocks.evidence[i].F;
    others.log_likelihood -= blocks.evidence[i].log_likelihood;
    others.measurements -= blocks.evidence[i].measurements;
  }
  return others;
}

std::vector<double> fold_evidence(const Blocks& blocks, const std::vector<std::vector<std::size_t>>& folds,
                                  const Eigen::VectorXd& theta, const ThetaPrior& prior) {
  const Evidence total = blocks.total();
  const double all = marginal(total, theta, prior);
  std::vector<double> result;
  result.reserve(folds.size());
  for (const std::vector<std::size_t>& fold : folds)
    result.push_back(all - marginal(without(total, blocks, fold), theta, prior));
  return result;
}

std::pair<double, double> heldout_gain(const std::vector<double>& better, const std::vector<double>& than) {
  const auto n = static_cast<double>(better.size());
  double sum = 0.0, square = 0.0;
  for (std::size_t f = 0; f < better.size(); ++f) {
    const double g = better[f] - than[f];
    sum += g;
    square += g * g;
  }
  const double variance = n > 1.0 ? std::max(0.0, (square - sum * sum / n) / (n - 1.0)) : 0.0;
  return {sum, std::sqrt(variance * n)};
}

}  // namespace leeway::gap
