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
  Blocks blocks;
  blocks.points = static_cast<std::size_t>(std::ceil(kPolicy.detect.block_s * campaign.time_scale() /
                                                     std::max(campaign.step_s, kPolicy.detect.least_step_s)));
  std::vector<std::vector<Evidence>> parts(fit.stretches.size());
  parallel_for(parts.size(), jobs, [&](std::size_t s) {
    parts[s] =
        evidence_by_blocks(fit.stretches[s], noise, blocks.points, extra.count, extra.of ? extra.of(s) : MoreColumns());
  });
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

}  // namespace leeway::gap
