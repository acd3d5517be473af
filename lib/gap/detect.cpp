#include "gap/detect.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "core/distributions.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"

namespace leeway::gap {
namespace {

constexpr double kFlat = 100.0;            // prior sd of an effect, by its nominal strength
constexpr double kLeastInformation = 1.0;  // d'^2 at nominal strength below which an effect is not excited
constexpr double kLeastEigenvalue = 1e-3;  // of the correlation matrix of an effect's columns
constexpr double kBlock_s = 60.0;          // at 3 m
constexpr std::size_t kScoreDraws = 20000;
constexpr std::size_t kFolds = 8;

// Everything about one effect with the noise levels that fit it best.
struct Refit {
  double p_value = 1.0, gain = 0.0, gain_sd = 0.0;
};

// ln p of a fold's data when beta and theta are fitted to the others: b'm - m'Fm/2 at the others' posterior mean.
double predicted(const Evidence& fold, const Evidence& others, const Eigen::VectorXd& precision,
                 const Eigen::VectorXd& prior_pull, Eigen::Index columns) {
  Eigen::MatrixXd M = others.F.topLeftCorner(columns, columns);
  M.diagonal() += precision.head(columns);
  const Eigen::VectorXd m = M.llt().solve(others.b.head(columns) - prior_pull.head(columns));
  return fold.b.head(columns).dot(m) - 0.5 * m.dot(fold.F.topLeftCorner(columns, columns) * m);
}

Refit refit(const Campaign& campaign, const FittedNull& fit, const EffectLibrary& library, std::size_t effect,
            const Eigen::VectorXd& wide_sd, std::size_t jobs) {
  const EffectLibrary::Entry& entry = library.entries()[effect];
  const Eigen::Index p = fit.theta.size(), count = entry.count;
  // The effect's columns are needed many times.
  std::vector<std::vector<Eigen::MatrixXd>> columns(fit.stretches.size());
  parallel_for(columns.size(), jobs, [&](std::size_t s) {
    const MoreColumns of = library.columns_of(s, {effect});
    columns[s].assign(fit.stretches[s].steps.size(), Eigen::MatrixXd(kShipStates, count));
    for (std::size_t k = 0; k < columns[s].size(); ++k) of(k, columns[s][k]);
  });
  LevelProblem problem{fit.stretches,
                       Eigen::VectorXd::Zero(p + count),
                       Eigen::VectorXd::Constant(p + count, kFlat),
                       {count,
                        [&](std::size_t s) {
                          return [&columns, s](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) { out = columns[s][k]; };
                        }},
                       fit.noise,
                       fit.level_prior_mean,
                       fit.level_prior_sd,
                       {0, 1, 2},
                       jobs};
  if (campaign.has_wind) problem.free.push_back(kWindLevel);
  problem.theta.head(p) = fit.theta;
  problem.prior_sd.head(p) = wide_sd;
  Levels unit = fit.level_unit;
  const Levels h = problem.minimize(levels_of(fit.noise), 10, unit);

  const auto project_at = [&](const Levels& levels) {
    return project(problem.total(noise_of(levels, fit.noise)), fit.theta, wide_sd);
  };
  // Degrees of freedom of the information about beta, which is known through the estimated levels.
  const Projected at = project_at(h);
  const ScoreTest test = score_test(at.b, at.F);
  Refit result;
  if (test.rank == 0 || (entry.is_one_sided && test.beta[0] < 0.0)) return result;
  constexpr double kStep = 0.15;
  std::vector<Levels> points{h};
  for (const int i : problem.free)
    for (const double sign : {1.0, -1.0}) points.push_back(h + sign * kStep * Levels::Unit(i));
  const std::vector<double> costs = problem.costs(points);
  double variance = 0.0;
  const auto information = [&](const Levels& levels) { return test.beta.dot(project_at(levels).F * test.beta); };
  for (std::size_t i = 0; i < problem.free.size(); ++i) {
    const double slope = std::log(information(points[1 + 2 * i]) / information(points[2 + 2 * i])) / (2.0 * kStep);
    const double curvature = (costs[1 + 2 * i] + costs[2 + 2 * i] - 2.0 * costs[0]) / (kStep * kStep);
    variance += slope * slope / std::max(curvature, 0.5);
  }
  const double dof = std::max(2.0 / std::max(variance, 1e-9), 4.0);

  // Blocks: correlation between them that the noise model does not know, and held-out gains.
  const Blocks blocks = blocks_of(campaign, fit, noise_of(h, fit.noise), problem.extra, jobs);
  const Evidence total = blocks.total();
  Eigen::VectorXd precision = problem.prior_sd.array().square().inverse();
  const Eigen::VectorXd prior_pull = precision.cwiseProduct(problem.theta);
  Eigen::MatrixXd M = total.F;
  M.diagonal() += precision;
  const Eigen::VectorXd fitted = M.llt().solve(total.b - prior_pull);
  Eigen::VectorXd direction(p + count);
  direction << -at.of_theta * test.beta, test.beta;
  const double kappa = overdispersion(blocks, direction, fitted);
  result.p_value = f_survival(test.statistic / kappa / test.rank, test.rank, dof);

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
  result.gain = std::accumulate(gains.begin(), gains.end(), 0.0) / n;
  double spread = 0.0;
  for (const double gain : gains) spread += (gain - result.gain) * (gain - result.gain);
  result.gain_sd = n > 1.0 ? std::sqrt(spread / (n - 1.0) / n) : 0.0;
  return result;
}

}  // namespace

Projected project(const Evidence& evidence, const Eigen::VectorXd& theta, const Eigen::VectorXd& prior_sd) {
  const Eigen::Index p = theta.size(), count = evidence.b.size() - p;
  const Eigen::VectorXd precision = prior_sd.array().square().inverse();
  Eigen::MatrixXd M = evidence.F.topLeftCorner(p, p);
  M.diagonal() += precision;
  const Eigen::MatrixXd cross = evidence.F.topRightCorner(p, count);
  Projected result;
  result.of_theta = M.llt().solve(cross);
  result.b =
      evidence.b.tail(count) - result.of_theta.transpose() * (evidence.b.head(p) - precision.cwiseProduct(theta));
  result.F = evidence.F.bottomRightCorner(count, count) - cross.transpose() * result.of_theta;
  return result;
}

ScoreTest score_test(const Eigen::VectorXd& b, const Eigen::MatrixXd& F) {
  ScoreTest test;
  const Eigen::Index n = b.size();
  test.beta = Eigen::VectorXd::Zero(n);
  test.inverse = Eigen::MatrixXd::Zero(n, n);
  if (!(F.diagonal().maxCoeff() > kLeastInformation)) return test;
  const Eigen::VectorXd scale = F.diagonal().cwiseMax(1e-12 * F.diagonal().maxCoeff()).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = scale.asDiagonal() * F * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double value = eigen.eigenvalues()[i];
    if (value < kLeastEigenvalue * static_cast<double>(n)) continue;
    const Eigen::VectorXd v = scale.cwiseProduct(eigen.eigenvectors().col(i));
    test.inverse += v * v.transpose() / value;
    ++test.rank;
  }
  test.beta = test.inverse * b;
  test.statistic = b.dot(test.beta);
  return test;
}

Evidence Blocks::total() const {
  Evidence sum(evidence.front().b.size());
  for (const Evidence& block : evidence) sum += block;
  return sum;
}

Blocks blocks_of(const Campaign& campaign, const FittedNull& fit, const Noise& noise, const ExtraColumns& extra,
                 std::size_t jobs) {
  Blocks blocks;
  blocks.points =
      static_cast<std::size_t>(std::ceil(kBlock_s * campaign.time_scale() / std::max(campaign.step_s, 1e-9)));
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
  if (different.size() >= 4) {
    for (const std::size_t recording : different) {
      folds.emplace_back();
      for (std::size_t i = 0; i < recordings.size(); ++i)
        if (recordings[i] == recording) folds.back().push_back(i);
    }
  } else {
    const std::size_t n = recordings.size(), count = std::min(kFolds, n);
    folds.resize(count);
    for (std::size_t i = 0; i < n; ++i) folds[i * count / n].push_back(i);
  }
  return folds;
}

Whiteness whiteness(const FittedNull& fit) {
  constexpr std::size_t kLags = 10;
  Whiteness result;
  double statistic = 0.0, dof = 0.0;
  for (int i = 0; i < kShipStates; ++i) {
    double square = 0.0, n = 0.0;
    std::array<double, kLags + 1> products{};
    for (const Smoothed& smoothed : fit.smoothed) {
      const std::vector<Vec6>& z = smoothed.innovations;
      // The first points settle the initial state.
      for (std::size_t k = 5; k < z.size(); ++k) {
        if (std::isnan(z[k][i])) continue;
        square += z[k][i] * z[k][i];
        n += 1.0;
        for (std::size_t lag = 1; lag <= kLags && k >= lag + 5; ++lag)
          if (!std::isnan(z[k - lag][i])) products[lag] += z[k][i] * z[k - lag][i];
      }
    }
    if (n < 30.0) continue;
    for (std::size_t lag = 1; lag <= kLags; ++lag) {
      const double rho = products[lag] / square;
      statistic += n * (n + 2.0) / (n - static_cast<double>(lag)) * rho * rho;
      result.largest = std::max(result.largest, std::abs(rho));
    }
    dof += kLags;
  }
  if (dof > kLevels) result.p_value = chi_squared_survival(statistic, dof - kLevels);
  return result;
}

Detection detect(const Campaign& campaign, const FittedNull& fit, const EffectLibrary& library,
                 const DetectOptions& options) {
  const Eigen::Index p = fit.theta.size(), count = library.columns();
  const Eigen::VectorXd& wide_sd = fit.prior_sd;
  std::vector<std::size_t> all(library.entries().size());
  std::iota(all.begin(), all.end(), std::size_t{0});

  std::vector<Evidence> parts(fit.stretches.size());
  parallel_for(parts.size(), options.jobs, [&](std::size_t s) {
    parts[s] = evidence(fit.stretches[s], fit.noise, count, library.columns_of(s, all));
  });
  Evidence total(p + count);
  for (const Evidence& part : parts) total += part;
  const Projected projected = project(total, fit.theta, wide_sd);

  struct TestedEffect {
    std::size_t effect;
    ScoreTest test;
    Screened screened;
  };
  std::vector<TestedEffect> candidates;
  for (const std::size_t e : all) {
    const EffectLibrary::Entry& entry = library.entries()[e];
    const Eigen::VectorXd b = projected.b.segment(entry.first, entry.count);
    const Eigen::MatrixXd F = projected.F.block(entry.first, entry.first, entry.count, entry.count);
    TestedEffect candidate{e, score_test(b, F), {}};
    if (candidate.test.rank == 0 || (entry.is_one_sided && candidate.test.beta[0] < 0.0)) continue;
    candidate.screened.name = entry.name;
    candidate.screened.p_value = chi_squared_survival(candidate.test.statistic, candidate.test.rank);
    // Strengths ~ N(0, nominal^2).
    Eigen::MatrixXd M = F;
    M.diagonal().array() += 1.0;
    const Eigen::LLT<Eigen::MatrixXd> factor(M);
    candidate.screened.log_bayes_factor =
        0.5 * b.dot(factor.solve(b)) - factor.matrixLLT().diagonal().array().log().sum();
    candidates.push_back(std::move(candidate));
  }
  Detection result;
  result.false_alarm = options.false_alarm;
  const Whiteness white = whiteness(fit);
  result.whiteness_p_value = white.p_value;
  result.largest_autocorrelation = white.largest;
  if (candidates.empty()) return result;

  // Share of i explained by j: tr(F_ij F_jj^-1 F_ji)/tr F_ii.
  const auto n = static_cast<Eigen::Index>(candidates.size());
  result.imitated.resize(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const EffectLibrary::Entry& a = library.entries()[candidates[static_cast<std::size_t>(i)].effect];
    result.compared.push_back(a.name);
    for (Eigen::Index j = 0; j < n; ++j) {
      const TestedEffect& other = candidates[static_cast<std::size_t>(j)];
      const EffectLibrary::Entry& b = library.entries()[other.effect];
      const Eigen::MatrixXd cross = projected.F.block(a.first, b.first, a.count, b.count);
      const double own = projected.F.block(a.first, a.first, a.count, a.count).trace();
      result.imitated(i, j) =
          i == j ? 1.0 : std::clamp((cross * other.test.inverse * cross.transpose()).trace() / own, 0.0, 1.0);
    }
  }

  std::sort(candidates.begin(), candidates.end(),
            [](const TestedEffect& a, const TestedEffect& b) { return a.screened.p_value < b.screened.p_value; });
  for (std::size_t i = 0; i < std::min(options.refitted, candidates.size()); ++i) {
    const Refit better = refit(campaign, fit, library, candidates[i].effect, wide_sd, options.jobs);
    candidates[i].screened.p_value = better.p_value;
    candidates[i].screened.heldout_gain = better.gain;
    candidates[i].screened.heldout_gain_sd = better.gain_sd;
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const TestedEffect& a, const TestedEffect& b) { return a.screened.p_value < b.screened.p_value; });

  // How often the smallest of all p-values is as small where there is nothing: the scores are N(0, F).
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(projected.F);
  const Eigen::MatrixXd root = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  RandomStream random(options.seed, "gap-detect");
  const double best = candidates.front().screened.p_value;
  // Counted at a level that draws can resolve, then carried on in proportion.
  const double level = std::max(best, 1e-3);
  std::size_t hits = 0;
  Eigen::VectorXd standard(count);
  for (std::size_t d = 0; d < kScoreDraws; ++d) {
    for (Eigen::Index i = 0; i < count; ++i) standard[i] = random.normal();
    const Eigen::VectorXd b = root * standard;
    bool hit = false;
    for (const TestedEffect& candidate : candidates) {
      const EffectLibrary::Entry& entry = library.entries()[candidate.effect];
      const auto part = b.segment(entry.first, entry.count);
      hit = hit || chi_squared_survival(part.dot(candidate.test.inverse * part), candidate.test.rank) <= level;
    }
    hits += hit ? 1 : 0;
  }
  const double share = static_cast<double>(hits + 1) / static_cast<double>(kScoreDraws + 1);
  result.p_value = std::min(1.0, share * best / level);
  result.heldout_gain = candidates.front().screened.heldout_gain;
  result.heldout_gain_sd = candidates.front().screened.heldout_gain_sd;
  for (const TestedEffect& candidate : candidates) result.effects.push_back(candidate.screened);
  return result;
}

}  // namespace leeway::gap
