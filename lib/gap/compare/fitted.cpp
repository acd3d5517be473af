#include "gap/compare/fitted.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

Eigen::VectorXd pull(const FittedNull& fit) { return fit.prior.pull(fit.theta); }

Eigen::MatrixXd curvature(const Eigen::MatrixXd& F, const FittedNull& fit) { return F + fit.prior.precision(); }

}  // namespace

std::set<std::string> name_set(const Hypothesis& hypothesis) {
  const std::vector<std::string> names = hypothesis.names();
  return {names.begin(), names.end()};
}

std::vector<EffectSpan> spans_of(const Hypothesis& hypothesis) {
  std::vector<EffectSpan> spans;
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < hypothesis.effects.size(); ++i) {
    const FreeEffect& effect = hypothesis.effects[i];
    const bool continues = i > 0 && effect.recording() && hypothesis.effects[i - 1].recording() &&
                           hypothesis.effects[i - 1].name() == effect.name();
    if (!continues) spans.push_back({i, 0, at, 0});
    ++spans.back().effects;
    spans.back().count += effect.size();
    at += effect.size();
  }
  return spans;
}

Eigen::VectorXd refitted(const FittedNull& fit, const Evidence& evidence) {
  return fit.theta + curvature(evidence.F, fit).llt().solve(evidence.b - pull(fit));
}

// How much correlation between blocks widens what is known of the effects' strength.
double overdispersion_of(const FittedNull& fit, const Blocks& blocks) {
  const Eigen::Index effects = fit.effects, coefficients = fit.theta.size() - 1 - effects;
  if (effects == 0) return 1.0;
  const Evidence total = blocks.total();
  const Eigen::MatrixXd M = curvature(total.F, fit);
  // Beta along what was fitted, and what the coefficients make of it.
  std::vector<Eigen::Index> rest;
  for (Eigen::Index i = 0; i < fit.theta.size(); ++i)
    if (i < coefficients || i >= coefficients + effects) rest.push_back(i);
  const Eigen::VectorXd beta = fit.theta.segment(coefficients, effects);
  const Eigen::VectorXd imitated =
      M(rest, rest).llt().solve(Eigen::VectorXd(M(rest, Eigen::seqN(coefficients, effects)) * beta));
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(fit.theta.size());
  direction.segment(coefficients, effects) = beta;
  for (std::size_t i = 0; i < rest.size(); ++i) direction[rest[i]] = -imitated[static_cast<Eigen::Index>(i)];
  return overdispersion(blocks, direction, M.llt().solve(total.b - pull(fit)));
}

}  // namespace leeway::gap
