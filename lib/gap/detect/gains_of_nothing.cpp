#include "gap/detect/gains_of_nothing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/linear_algebra.hpp"
#include "core/random.hpp"

namespace leeway::gap {

std::vector<double> gains_of_nothing(const Projected& beside, const std::vector<LinearCandidate>& candidates,
                                     std::size_t draws, std::uint64_t seed) {
  // Beside theta the scores of nothing are N(0, F).
  struct Alone {
    const LinearCandidate& candidate;
    Eigen::LLT<Eigen::MatrixXd> factor;
    double constant;  // of the gain
  };
  std::vector<Alone> alone;
  for (const LinearCandidate& c : candidates) {
    const Eigen::Index n = c.z.size();
    Eigen::MatrixXd M = beside.F.block(c.first, c.first, n, n);
    M.diagonal().array() += 1.0;
    Alone one{c, Eigen::LLT<Eigen::MatrixXd>(M), 0.0};
    const double at_start = c.at_start ? beside.F(*c.at_start, *c.at_start) : 0.0;
    one.constant = -0.5 * (at_start + c.z.squaredNorm()) - one.factor.matrixLLT().diagonal().array().log().sum();
    if (std::isfinite(one.constant)) alone.push_back(std::move(one));
  }
  if (alone.empty() || !beside.F.allFinite()) return {};
  const Eigen::MatrixXd root = root_of_scores(beside.F);
  RandomStream random(seed, "gap-nothing");
  std::vector<double> result;
  result.reserve(draws);
  Eigen::VectorXd standard(beside.F.rows());
  for (std::size_t d = 0; d < draws; ++d) {
    for (double& x : standard) x = random.normal();
    const Eigen::VectorXd b = root * standard;
    double most = -std::numeric_limits<double>::infinity();
    for (const Alone& one : alone) {
      const LinearCandidate& c = one.candidate;
      Eigen::VectorXd score = b.segment(c.first, c.z.size()) - c.z;
      double gain = one.constant;
      if (c.at_start) {
        score -= beside.F.block(c.first, *c.at_start, c.z.size(), 1);
        gain += b[*c.at_start];
      }
      most = std::max(most, gain + 0.5 * score.dot(one.factor.solve(score)));
    }
    result.push_back(most);
  }
  std::ranges::sort(result);
  return result;
}

double chance_of_gain(const std::vector<double>& drawn, double gain) {
  const auto as_much = drawn.end() - std::ranges::lower_bound(drawn, gain);
  const double beyond = std::max(0.0, gain - drawn.back());
  return static_cast<double>(as_much + 1) / static_cast<double>(drawn.size() + 1) * std::exp(-beyond);
}

}  // namespace leeway::gap
