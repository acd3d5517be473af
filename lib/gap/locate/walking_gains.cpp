#include "gap/locate/walking_gains.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "gap/filter/reference_units.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// One module's gain, constant over each block.
struct GainEvidence {
  Eigen::VectorXd b;
  Eigen::MatrixXd F;
};

GainEvidence gain_evidence(const BlockEvidence& evidence, std::size_t module) {
  const std::size_t n = evidence.blocks.size();
  const int kind = 3 + static_cast<int>(module);
  GainEvidence result{Eigen::VectorXd(n), Eigen::MatrixXd(n, n)};
  for (std::size_t i = 0; i < n; ++i) {
    result.b[static_cast<Eigen::Index>(i)] = evidence.b[evidence.column(i, kind)];
    for (std::size_t j = 0; j < n; ++j) result.F(i, j) = evidence.F(evidence.column(i, kind), evidence.column(j, kind));
  }
  return result;
}

// Covariance of a random walk with steps of variance 1: each stretch walks for itself, from an offset of its own.
Eigen::MatrixXd walk_over(const std::vector<Block>& blocks) {
  const std::size_t n = blocks.size();
  Eigen::MatrixXd walk(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t first = i;
    while (first > 0 && blocks[first - 1].stretch == blocks[i].stretch) --first;
    for (std::size_t j = 0; j < n; ++j)
      walk(i, j) = blocks[i].stretch == blocks[j].stretch ? 1.0 + static_cast<double>(std::min(i, j) - first) : 0.0;
  }
  return walk;
}

// The most likely walk, with steps of the most likely size.
struct Walk {
  double log_likelihood_gain = 0.0;
  Eigen::VectorXd gain;  // by block
};

Walk best_walk(const GainEvidence& of, const Eigen::MatrixXd& walk) {
  Walk best{0.0, Eigen::VectorXd::Zero(of.b.size())};
  for (const double q : kPolicy.locate.walk_steps) {
    const Eigen::MatrixXd L = (q * q * walk).llt().matrixL();
    Eigen::MatrixXd H = L.transpose() * of.F * L;
    H.diagonal().array() += 1.0;
    const Eigen::LLT<Eigen::MatrixXd> factor(H);
    const Eigen::VectorXd g = L.transpose() * of.b, solved = factor.solve(g);
    const double gained = 0.5 * g.dot(solved) - factor.matrixLLT().diagonal().array().log().sum();
    if (gained > best.log_likelihood_gain) {
      best.log_likelihood_gain = gained;
      best.gain = L * solved;
    }
  }
  return best;
}

// What is left of the residual when a gain has walked, by what there was: root mean square over the axes.
double left_by(const Eigen::VectorXd& gain, const Module& module, const Model<double>& null, const Campaign& campaign,
               const FittedNull& fit, const std::vector<Block>& blocks, std::size_t jobs) {
  std::vector<Vec3<double>> before(fit.stretches.size()), after(fit.stretches.size());
  const Vec3<double> weight = reference_acceleration(campaign.ship).cwiseInverse();
  parallel_for(fit.stretches.size(), jobs, [&](std::size_t s) {
    LinearStretch moved = fit.stretches[s];
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (blocks[i].stretch != s) continue;
      for (std::size_t k = blocks[i].begin; k < blocks[i].end && k < moved.steps.size(); ++k) {
        const std::vector<StepInputs<double>>& inputs = moved.data->inputs[k];
        const double h = moved.data->dt_s(k) / static_cast<double>(inputs.size());
        moved.steps[k].offset += gain[static_cast<Eigen::Index>(i)] / kPolicy.locate.gain_step *
                                 moved.steps[k].answered(advance<double>(module.scaled, moved.path[k], inputs, h) -
                                                         advance<double>(null, moved.path[k], inputs, h));
      }
    }
    const Smoothed smoothed = smooth(moved, fit.noise, Eigen::VectorXd::Zero(fit.theta.size()));
    before[s] = after[s] = Vec3<double>::Zero();
    for (std::size_t k = 0; k < smoothed.state.size(); ++k) {
      before[s] += fit.smoothed[s].state[k].segment<3>(kErrorStart).cwiseProduct(weight).cwiseAbs2();
      after[s] += smoothed.state[k].segment<3>(kErrorStart).cwiseProduct(weight).cwiseAbs2();
    }
  });
  double was = 0.0, is = 0.0;
  for (std::size_t s = 0; s < before.size(); ++s) was += before[s].sum(), is += after[s].sum();
  return was > 0.0 ? std::sqrt(is / was) : 1.0;
}

}  // namespace

std::vector<WalkingGain> walking_gains(const Campaign& campaign, const FittedNull& fit, const BlockEvidence& evidence,
                                       const std::vector<Module>& modules, std::size_t jobs) {
  std::vector<WalkingGain> result;
  if (modules.empty()) return result;
  Model<double> null(campaign.ship);
  apply_uncertainty(null, fit.theta);
  const Eigen::MatrixXd walk = walk_over(evidence.blocks);
  for (std::size_t m = 0; m < modules.size(); ++m) {
    const GainEvidence of = gain_evidence(evidence, m);
    if (of.F.trace() < kPolicy.locate.least_gain_information) continue;  // a module at rest
    const Walk best = best_walk(of, walk);
    if (!(best.log_likelihood_gain > 0.0)) continue;
    const double gain_sd = std::sqrt(best.gain.squaredNorm() / static_cast<double>(evidence.blocks.size()));
    const double left = left_by(best.gain, modules[m], null, campaign, fit, evidence.blocks, jobs);
    // Otherwise it moves the error, and whitens nothing.
    if (left < 1.0) result.push_back({modules[m].name, best.log_likelihood_gain, gain_sd, left});
  }
  std::sort(result.begin(), result.end(),
            [](const WalkingGain& a, const WalkingGain& b) { return a.log_likelihood_gain > b.log_likelihood_gain; });
  return result;
}

}  // namespace leeway::gap
