#include "gap/fit/coefficient_scale.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/linear_algebra.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

// theta as the recordings leave it: Gaussian.
struct ThetaPosterior {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

// How theta follows where a coefficient is off by far more: the covariance before grows by `added` in one place, and
// with the narrow prior's precision P all follows from u = P e and the posterior's u'm and u'V u (Sherman & Morrison).
struct Freed {
  double grown, kept;    // determinants of the covariances before and after, by those of the narrow prior
  double share, pulled;  // added/grown, u'm
  Eigen::VectorXd Vu;

  Freed(const ThetaPosterior& posterior, const PriorWidths& widths, Eigen::Index i)
      : Vu(Eigen::VectorXd::Zero(posterior.mean.size())) {
    const Eigen::MatrixXd& P = widths.prior.precision();
    const double narrow = widths.prior.sd()[i], wide = widths.slab[i], added = wide * wide - narrow * narrow;
    const std::vector<Eigen::Index> linked = widths.prior.linked(i);
    pulled = 0.0;
    for (const Eigen::Index j : linked) {
      Vu += P(j, i) * posterior.covariance.col(j);
      pulled += P(j, i) * posterior.mean[j];
    }
    double u_V_u = 0.0;
    for (const Eigen::Index j : linked) u_V_u += P(j, i) * Vu[j];
    grown = 1.0 + added * P(i, i);
    share = added / grown;
    kept = 1.0 - share * u_V_u;
  }

  void take(ThetaPosterior& posterior) const {
    posterior.mean += share * pulled / kept * Vu;
    posterior.covariance += share / kept * Vu * Vu.transpose();
  }
};

// Odds, prior times Bayes factor, of each of n coefficients being off by far more against not.
Eigen::VectorXd odds_of_slabs(const ThetaPosterior& posterior, const PriorWidths& widths, double n) {
  Eigen::VectorXd odds = Eigen::VectorXd::Zero(posterior.mean.size());
  for (Eigen::Index i = 0; i < odds.size(); ++i) {
    if (!(widths.slab[i] > widths.prior.sd()[i])) continue;
    const Freed freed(posterior, widths, i);
    const double mean = posterior.mean[i] + freed.share * freed.pulled / freed.kept * freed.Vu[i],
                 variance = posterior.covariance(i, i) + freed.share / freed.kept * freed.Vu[i] * freed.Vu[i];
    const double side = widths.side[i] * mean / std::sqrt(variance);
    const double share = widths.side[i] == 0.0 ? 1.0 : std::erfc(-side / std::sqrt(2.0));
    const double exponent = 0.5 * freed.share * freed.pulled * freed.pulled / freed.kept;
    odds[i] = share * kPolicy.fit.slab_odds / n / std::sqrt(freed.grown * freed.kept) *
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
Slabs slabs_of(ThetaPosterior posterior, PriorWidths widths) {
  Slabs result{0.0, Eigen::VectorXd::Zero(posterior.mean.size())};
  const auto n = static_cast<double>((widths.slab.array() > 0.0).count());
  if (n == 0.0) return result;
  std::vector<Eigen::Index> set;
  double sum = 1.0;  // of all weights so far, that of the set being 1
  for (;;) {
    const Eigen::VectorXd odds = odds_of_slabs(posterior, widths, n);
    sum += odds.sum();
    result.off += odds;
    for (const Eigen::Index i : set) result.off[i] += odds.sum();
    Eigen::Index next = 0;
    const double likeliest = odds.maxCoeff(&next);
    if (!(likeliest > 1.0)) break;
    sum /= likeliest;
    result.off /= likeliest;
    result.log_weight += std::log(likeliest);
    Freed(posterior, widths, next).take(posterior);
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
  const auto n = static_cast<Eigen::Index>(parameters.size());
  const auto faults =
      static_cast<Eigen::Index>(std::ranges::count(parameters, true, &UncertainParameter::is_of_sensor));
  const Eigen::Index coefficients = n - 1 - effects - faults;
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
  return FileEvidenceBeside(evidence.F, theta, widths).with(evidence.log_likelihood, evidence.b, {});
}

FileEvidenceBeside::FileEvidenceBeside(const Eigen::MatrixXd& F, Eigen::VectorXd theta, std::vector<PriorWidths> widths)
    : theta_(std::move(theta)), widths_(std::move(widths)) {
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(theta_.size(), theta_.size());
  for (const PriorWidths& one : widths_) {
    const Eigen::LLT<Eigen::MatrixXd> factors(F + one.prior.precision());
    alone_.push_back({factors.solve(unit), -2.0 * factors.matrixLLT().diagonal().array().log().sum()});
  }
}

FileEvidence FileEvidenceBeside::with(double log_likelihood, const Eigen::VectorXd& score,
                                      const MoreCoordinates& more) const {
  FileEvidence result{-std::numeric_limits<double>::infinity(), widths_.front(), Eigen::VectorXd::Zero(theta_.size())};
  double most = -std::numeric_limits<double>::infinity(), sum = 0.0;
  Eigen::VectorXd off_now;
  for (std::size_t i = 0; i < widths_.size(); ++i) {
    const PriorWidths& one = widths_[i];
    const Eigen::VectorXd slope = score - one.prior.pull(theta_);
    Eigen::VectorXd step = alone_[i].covariance * slope;
    double log_marginal =
        log_likelihood + one.prior.log_density(theta_) + 0.5 * (slope.dot(step) + alone_[i].log_determinant);
    const bool has_slabs = (one.slab.array() > 0.0).any();
    ThetaPosterior posterior;
    if (has_slabs) posterior.covariance = alone_[i].covariance;
    if (more.z.size() > 0) {  // the inverse by blocks (Schur)
      const Eigen::MatrixXd W = alone_[i].covariance * more.with_theta;
      const Eigen::LLT<Eigen::MatrixXd> own(Eigen::MatrixXd(
          more.own + Eigen::MatrixXd::Identity(more.z.size(), more.z.size()) - more.with_theta.transpose() * W));
      const Eigen::VectorXd left = more.score - more.z - more.with_theta.transpose() * step, dz = own.solve(left);
      log_marginal += 0.5 * (left.dot(dz) - more.z.squaredNorm()) - own.matrixLLT().diagonal().array().log().sum();
      step -= W * dz;
      if (has_slabs) posterior.covariance += W * own.solve(W.transpose());
    }
    posterior.mean = theta_ + step;
    const Slabs slabs =
        has_slabs ? slabs_of(std::move(posterior), one) : Slabs{0.0, Eigen::VectorXd::Zero(theta_.size())};
    const double here = one.log_weight + log_marginal + slabs.log_weight;
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
