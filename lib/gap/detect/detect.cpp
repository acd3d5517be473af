#include "gap/detect/detect.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/distributions.hpp"
#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "gap/detect/refit.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// An effect that the recordings excite.
struct TestedEffect {
  std::size_t effect;  // its place in the library
  ScoreTest test;
  Screened screened;
};

// What the recordings say about all columns of the library.
Projected projected_columns(const FittedNull& fit, const EffectLibrary& library, std::size_t jobs) {
  std::vector<std::size_t> all(library.entries().size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::vector<Evidence> parts(fit.stretches.size());
  parallel_for(parts.size(), jobs, [&](std::size_t s) {
    parts[s] = evidence(fit.stretches[s], fit.noise, library.columns(), library.columns_of(s, all));
  });
  Evidence total(fit.theta.size() + library.columns());
  for (const Evidence& part : parts) total += part;
  return project(total, fit.theta, fit.prior);
}

std::vector<TestedEffect> tested_effects(const Projected& projected, const EffectLibrary& library) {
  std::vector<TestedEffect> tested;
  for (std::size_t e = 0; e < library.entries().size(); ++e) {
    const EffectLibrary::Entry& entry = library.entries()[e];
    const Eigen::VectorXd b = projected.b.segment(entry.first, entry.count);
    const Eigen::MatrixXd F = projected.F.block(entry.first, entry.first, entry.count, entry.count);
    TestedEffect one{e, score_test(b, F), {}};
    if (one.test.rank == 0 || (entry.is_one_sided && one.test.beta[0] < 0.0)) continue;
    one.screened.name = entry.name;
    one.screened.p_value = chi_squared_survival(one.test.statistic, one.test.rank);
    // Strengths ~ N(0, nominal^2).
    Eigen::MatrixXd M = F;
    M.diagonal().array() += 1.0;
    const Eigen::LLT<Eigen::MatrixXd> factor(M);
    one.screened.log_bayes_factor = 0.5 * b.dot(factor.solve(b)) - factor.matrixLLT().diagonal().array().log().sum();
    tested.push_back(std::move(one));
  }
  return tested;
}

// Share of i explained by j: tr(F_ij F_jj^-1 F_ji)/tr F_ii.
void compare_signatures(Detection& result, const std::vector<TestedEffect>& tested, const Projected& projected,
                        const EffectLibrary& library) {
  const auto n = static_cast<Eigen::Index>(tested.size());
  result.imitated.resize(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const EffectLibrary::Entry& a = library.entries()[tested[static_cast<std::size_t>(i)].effect];
    result.compared.push_back(a.name);
    for (Eigen::Index j = 0; j < n; ++j) {
      const TestedEffect& other = tested[static_cast<std::size_t>(j)];
      const EffectLibrary::Entry& b = library.entries()[other.effect];
      const Eigen::MatrixXd cross = projected.F.block(a.first, b.first, a.count, b.count);
      const double own = projected.F.block(a.first, a.first, a.count, a.count).trace();
      result.imitated(i, j) =
          i == j ? 1.0 : std::clamp((cross * other.test.inverse * cross.transpose()).trace() / own, 0.0, 1.0);
    }
  }
}

void sort_by_p_value(std::vector<TestedEffect>& tested) {
  std::sort(tested.begin(), tested.end(),
            [](const TestedEffect& a, const TestedEffect& b) { return a.screened.p_value < b.screened.p_value; });
}

// How often the smallest of all p-values is as small as `best` where there is nothing: the scores are N(0, F).
double family_wise(double best, const std::vector<TestedEffect>& tested, const Projected& projected,
                   const EffectLibrary& library, std::uint64_t seed) {
  const Eigen::MatrixXd root = root_of_scores(projected.F);
  RandomStream random(seed, "gap-detect");
  // Counted at a level that draws can resolve, then carried on in proportion.
  const double level = std::max(best, kPolicy.detect.resolved_p_value);
  std::size_t hits = 0;
  const Eigen::Index count = library.columns();
  Eigen::VectorXd standard(count);
  for (std::size_t d = 0; d < kPolicy.detect.score_draws; ++d) {
    for (Eigen::Index i = 0; i < count; ++i) standard[i] = random.normal();
    const Eigen::VectorXd b = root * standard;
    bool hit = false;
    for (const TestedEffect& one : tested) {
      const EffectLibrary::Entry& entry = library.entries()[one.effect];
      const auto part = b.segment(entry.first, entry.count);
      hit = hit || chi_squared_survival(part.dot(one.test.inverse * part), one.test.rank) <= level;
    }
    hits += hit ? 1 : 0;
  }
  const double share = static_cast<double>(hits + 1) / static_cast<double>(kPolicy.detect.score_draws + 1);
  return std::min(1.0, share * best / level);
}

}  // namespace

Detection detect(const Campaign& campaign, const FittedNull& fit, const EffectLibrary& library,
                 const DetectOptions& options) {
  const Projected projected = projected_columns(fit, library, options.jobs);
  std::vector<TestedEffect> tested = tested_effects(projected, library);
  Detection result;
  result.false_alarm = options.false_alarm;
  const Whiteness white = whiteness(fit);
  result.whiteness_p_value = white.p_value;
  result.largest_autocorrelation = white.largest;
  if (tested.empty()) return result;
  compare_signatures(result, tested, projected, library);

  sort_by_p_value(tested);
  for (std::size_t i = 0; i < std::min(options.refitted, tested.size()); ++i) {
    const Refit better = refit(campaign, fit, library, tested[i].effect, options.jobs);
    tested[i].screened.p_value = better.p_value;
    tested[i].screened.heldout_gain = better.gain;
    tested[i].screened.heldout_gain_sd = better.gain_sd;
  }
  sort_by_p_value(tested);
  result.p_value = family_wise(tested.front().screened.p_value, tested, projected, library, options.seed);
  result.heldout_gain = tested.front().screened.heldout_gain;
  result.heldout_gain_sd = tested.front().screened.heldout_gain_sd;
  for (const TestedEffect& one : tested) result.effects.push_back(one.screened);
  return result;
}

}  // namespace leeway::gap
