#include "gap/detect/refit.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/distributions.hpp"
#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "gap/detect/blocks.hpp"
#include "gap/detect/score_test.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// An effect's columns by stretch and step, which are needed many times: 6 x count.
using StepColumns = std::vector<std::vector<Eigen::MatrixXd>>;

StepColumns columns_of(const FittedNull& fit, const EffectLibrary& library, std::size_t effect, std::size_t jobs) {
  StepColumns columns(fit.stretches.size());
  parallel_for(columns.size(), jobs, [&](std::size_t s) {
    const MoreColumns of = library.columns_of(s, {effect});
    columns[s].assign(fit.stretches[s].steps.size(), Eigen::MatrixXd(kShipStates, library.entries()[effect].count));
    for (std::size_t k = 0; k < columns[s].size(); ++k) of(k, columns[s][k]);
  });
  return columns;
}

// The noise levels beside theta and the effect.
LevelProblem problem_of(const Campaign& campaign, const FittedNull& fit, const StepColumns& columns, Eigen::Index count,
                        std::size_t jobs) {
  const Eigen::Index p = fit.theta.size();
  LevelProblem problem{fit.stretches,
                       Eigen::VectorXd::Zero(p + count),
                       fit.prior.with(p, Eigen::VectorXd::Constant(count, kPolicy.detect.flat_prior_sd)),
                       {count,
                        [&columns](std::size_t s) {
                          return [&columns, s](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) { out = columns[s][k]; };
                        }},
                       fit.noise,
                       fit.level_prior_mean,
                       fit.level_prior_sd,
                       {0, 1, 2},
                       jobs};
  if (campaign.has_wind) problem.free.push_back(kWindLevel);
  problem.theta.head(p) = fit.theta;
  return problem;
}

Projected project_at(const LevelProblem& problem, const FittedNull& fit, const Levels& levels) {
  return project(problem.total(noise_of(levels, fit.noise)), fit.theta, fit.prior);
}

// Degrees of freedom of the information about beta, which is known through the estimated levels h.
double degrees_of_freedom(const LevelProblem& problem, const FittedNull& fit, const Levels& h,
                          const Eigen::VectorXd& beta) {
  std::vector<Levels> points{h};
  for (const int i : problem.free)
    for (const double sign : {1.0, -1.0}) points.push_back(h + sign * kPolicy.detect.level_step * Levels::Unit(i));
  const std::vector<double> costs = problem.costs(points);
  double variance = 0.0;
  const auto information = [&](const Levels& levels) { return beta.dot(project_at(problem, fit, levels).F * beta); };
  for (std::size_t i = 0; i < problem.free.size(); ++i) {
    const double slope =
        std::log(information(points[1 + 2 * i]) / information(points[2 + 2 * i])) / (2.0 * kPolicy.detect.level_step);
    const double curvature = (costs[1 + 2 * i] + costs[2 + 2 * i] - 2.0 * costs[0]) /
                             (kPolicy.detect.level_step * kPolicy.detect.level_step);
    variance += slope * slope / std::max(curvature, kPolicy.detect.least_curvature);
  }
  return std::max(2.0 / std::max(variance, kPolicy.detect.least_variance), kPolicy.detect.least_dof);
}

// ln p of a fold's data when beta and theta are fitted to the others: b'm - m'Fm/2 at the others' posterior mean.
double predicted(const Evidence& fold, const Evidence& others, const Eigen::MatrixXd& precision,
                 const Eigen::VectorXd& prior_pull, Eigen::Index columns) {
  const Eigen::MatrixXd M = others.F.topLeftCorner(columns, columns) + precision.topLeftCorner(columns, columns);
  const Eigen::VectorXd m = M.llt().solve(others.b.head(columns) - prior_pull.head(columns));
  return fold.b.head(columns).dot(m) - 0.5 * m.dot(fold.F.topLeftCorner(columns, columns) * m);
}

// What the effect gains over what is left out in turn.
//   p, count  numbers of the parameters and of the effect's columns
//   kappa     by which errors are wider than the model says
void add_heldout_gain(Refit& result, const Campaign& campaign, const Blocks& blocks, const Evidence& total,
                      const Eigen::MatrixXd& precision, const Eigen::VectorXd& prior_pull, Eigen::Index p,
                      Eigen::Index count, double kappa) {
  const std::vector<std::vector<std::size_t>> folds = folds_of(campaign, blocks);
  std::vector<double> gains;
  for (std::size_t f = 0; f < folds.size(); ++f) {
    Evidence fold(p + count), others = total;
    for (const std::size_t i : folds[f]) fold += blocks.evidence[i];
    others.b -= fold.b;
    others.F -= fold.F;
    gains.push_back((predicted(fold, others, precision, prior_pull, p + count) -
                     predicted(fold, others, precision, prior_pull, p)) /
                    kappa);
  }
  const auto n = static_cast<double>(gains.size());
  result.gain = std::accumulate(gains.begin(), gains.end(), 0.0);
  double spread = 0.0;
  for (const double gain : gains) spread += (gain - result.gain / n) * (gain - result.gain / n);
  result.gain_sd = n > 1.0 ? std::sqrt(spread / (n - 1.0) * n) : 0.0;
}

}  // namespace

Refit refit(const Campaign& campaign, const FittedNull& fit, const EffectLibrary& library, std::size_t effect,
            std::size_t jobs) {
  const EffectLibrary::Entry& entry = library.entries()[effect];
  const Eigen::Index p = fit.theta.size(), count = entry.count;
  const StepColumns columns = columns_of(fit, library, effect, jobs);
  const LevelProblem problem = problem_of(campaign, fit, columns, count, jobs);
  LevelCurvature curvature = fit.level_curvature;
  const Levels h = problem.minimize(levels_of(fit.noise), static_cast<int>(kPolicy.detect.level_iterations), curvature);
  const Projected at = project_at(problem, fit, h);
  const ScoreTest test = score_test(at.b, at.F);
  Refit result;
  if (test.rank == 0 || (entry.is_one_sided && test.beta[0] < 0.0)) return result;
  const double dof = degrees_of_freedom(problem, fit, h, test.beta);

  // Blocks: correlation between them that the noise model does not know, and held-out gains.
  const Blocks blocks = blocks_of(campaign, fit, noise_of(h, fit.noise), problem.extra, jobs);
  const Evidence total = blocks.total();
  const Eigen::MatrixXd& precision = problem.prior.precision();
  const Eigen::VectorXd prior_pull = problem.prior.pull(problem.theta);
  const Eigen::VectorXd fitted = (total.F + precision).llt().solve(total.b - prior_pull);
  Eigen::VectorXd direction(p + count);
  direction << -at.of_theta * test.beta, test.beta;
  const double kappa = overdispersion(blocks, direction, fitted);
  result.p_value = f_survival(test.statistic / kappa / test.rank, test.rank, dof);
  add_heldout_gain(result, campaign, blocks, total, precision, prior_pull, p, count, kappa);
  return result;
}

}  // namespace leeway::gap
