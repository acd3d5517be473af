#include "gap/fit/coefficient_scale.hpp"

#include <cmath>
#include <limits>

#include "core/linear_algebra.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// Odds, prior times Bayes factor, of each of n coefficients being off by far more against not. The covariance before
// grows by `added` in one place; with the narrow prior's precision P, and theta known as N(m, V) with it, all follows
// from u = P e, u'm and u'V u (Sherman & Morrison).
Eigen::VectorXd odds_of_slabs(const Evidence& evidence, const Eigen::VectorXd& theta, const PriorWidths& widths,
                              double n) {
  Eigen::VectorXd odds = Eigen::VectorXd::Zero(theta.size());
  const Eigen::MatrixXd& P = widths.prior.precision();
  const Eigen::MatrixXd M = evidence.F + P;
  const Eigen::MatrixXd covariance = M.llt().solve(Eigen::MatrixXd::Identity(M.rows(), M.cols()));
  const Eigen::VectorXd mean = theta + covariance * (evidence.b - widths.prior.pull(theta));
  for (Eigen::Index i = 0; i < odds.size(); ++i) {
    const double narrow = widths.prior.sd()[i], wide = widths.slab[i];
    if (!(wide > narrow)) continue;
    const double added = wide * wide - narrow * narrow, grown = 1.0 + added * P(i, i), freed = added / grown;
    Eigen::VectorXd Vu = Eigen::VectorXd::Zero(theta.size());
    double u_m = 0.0, u_V_u = 0.0;
    const std::vector<Eigen::Index> linked = widths.prior.linked(i);
    for (const Eigen::Index j : linked) {
      Vu += P(j, i) * covariance.col(j);
      u_m += P(j, i) * mean[j];
    }
    for (const Eigen::Index j : linked) u_V_u += P(j, i) * Vu[j];
    const double kept = 1.0 - freed * u_V_u;
    const double wide_mean = mean[i] + Vu[i] * freed * u_m / kept,
                 wide_variance = covariance(i, i) + freed * Vu[i] * Vu[i] / kept;
    const double side = widths.side[i] * wide_mean / std::sqrt(wide_variance);
    const double share = widths.side[i] == 0.0 ? 1.0 : std::erfc(-side / std::sqrt(2.0));
    const double exponent = 0.5 * freed * u_m * u_m / kept;
    odds[i] = share * kPolicy.fit.slab_odds / n / std::sqrt(grown * kept) *
              std::exp(std::min(exponent, kPolicy.fit.most_slab_nats));
  }
  return odds;
}

struct Slabs {
  double log_weight = 0.0;  // of all sets of what is off by far more, against none
  Eigen::VectorXd off;      // the probability that each is in the set
};

// Sets of one, of two beside the likeliest of these, and so on as long as one more is likelier off than not: what else
// there is of that size is less probable.
Slabs slabs_of(const Evidence& evidence, const Eigen::VectorXd& theta, PriorWidths widths) {
  Slabs result{0.0, Eigen::VectorXd::Zero(theta.size())};
  const auto n = static_cast<double>((widths.slab.array() > 0.0).count());
  if (n == 0.0) return result;
  std::vector<Eigen::Index> set;
  double sum = 1.0;  // of all weights so far, that of the set being 1
  for (;;) {
    const Eigen::VectorXd odds = odds_of_slabs(evidence, theta, widths, n);
    sum += odds.sum();
    result.off += odds;
    for (const Eigen::Index i : set) result.off[i] += odds.sum();
    Eigen::Index next = 0;
    const double likeliest = odds.maxCoeff(&next);
    if (!(likeliest > 1.0)) break;
    sum /= likeliest;
    result.off /= likeliest;
    result.log_weight += std::log(likeliest);
    widths.prior.widen(next, widths.slab[next]);
    widths.slab[next] = 0.0;
    set.push_back(next);
  }
  result.log_weight += std::log(sum) - n * std::log1p(kPolicy.fit.slab_odds / n);
  result.off /= sum;
  return result;
}

PriorWidths widths_at(const ThetaPrior& stated, const std::vector<UncertainParameter>& parameters, Eigen::Index effects,
                      double scale) {
  const auto n = static_cast<Eigen::Index>(parameters.size()), coefficients = n - 1 - effects;
  PriorWidths result{stated.scaled(coefficients, scale), Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n), scale,
                     0.0};
  for (Eigen::Index i = 0; i < n; ++i) {
    const UncertainParameter& p = parameters[static_cast<std::size_t>(i)];
    if (i >= coefficients || p.is_absolute || (!p.may_be_far_more && !p.may_be_far_less)) continue;
    result.slab[i] = kPolicy.fit.slab_log_sd;
    result.side[i] = (p.may_be_far_more ? 1.0 : 0.0) - (p.may_be_far_less ? 1.0 : 0.0);
  }
  return result;
}

}  // namespace

std::vector<PriorWidths> widths_by_scale(const ThetaPrior& stated, const std::vector<UncertainParameter>& parameters,
                                         Eigen::Index effects) {
  constexpr const FitPolicy& of = kPolicy.fit;
  std::vector<PriorWidths> result;
  result.reserve(of.scales);
  double sum = 0.0;
  for (std::size_t i = 0; i < of.scales; ++i) {
    const double z = of.scale_reach_sd * (2.0 * static_cast<double>(i) / static_cast<double>(of.scales - 1) - 1.0);
    result.push_back(widths_at(stated, parameters, effects, std::exp(of.scale_log_sd * z)));
    result.back().log_weight = -0.5 * z * z;
    sum += std::exp(result.back().log_weight);
  }
  for (PriorWidths& widths : result) widths.log_weight -= std::log(sum);
  return result;
}

std::vector<PriorWidths> with_coordinates(std::vector<PriorWidths> widths, Eigen::Index place, Eigen::Index count) {
  const auto insert = [&](Eigen::VectorXd& of) {
    if (of.size() == 0) return;
    Eigen::VectorXd longer(of.size() + count);
    longer << of.head(place), Eigen::VectorXd::Zero(count), of.tail(of.size() - place);
    of = std::move(longer);
  };
  for (PriorWidths& one : widths) {
    one.prior = one.prior.with(place, Eigen::VectorXd::Ones(count));
    insert(one.slab);
    insert(one.side);
  }
  return widths;
}

FileEvidence file_evidence(const Evidence& evidence, const Eigen::VectorXd& theta,
                           const std::vector<PriorWidths>& widths) {
  FileEvidence result{-std::numeric_limits<double>::infinity(), widths.front(), Eigen::VectorXd::Zero(theta.size())};
  double most = -std::numeric_limits<double>::infinity(), sum = 0.0;
  Eigen::VectorXd off_now;
  for (const PriorWidths& one : widths) {
    const Slabs slabs = slabs_of(evidence, theta, one);
    const double here = one.log_weight + marginal(evidence, theta, one.prior) + slabs.log_weight;
    if (!std::isfinite(here)) continue;
    if (here > most) {
      const double less = std::exp(most - here);
      sum *= less;
      result.off *= less;
      most = here;
      result.likeliest = one;
      off_now = slabs.off;
    }
    sum += std::exp(here - most);
    result.off += std::exp(here - most) * slabs.off;
  }
  if (!(sum > 0.0)) return result;
  result.log_evidence = most + std::log(sum);
  result.off /= sum;
  for (Eigen::Index i = 0; i < off_now.size(); ++i)
    if (off_now[i] > 0.0) {
      const double narrow = result.likeliest.prior.sd()[i], wide = result.likeliest.slab[i];
      result.likeliest.prior.widen(
          i, 1.0 / std::sqrt((1.0 - off_now[i]) / (narrow * narrow) + off_now[i] / (wide * wide)));
    }
  return result;
}

}  // namespace leeway::gap
