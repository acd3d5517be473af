#include "gap/compare/latent_forces.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "core/linear_algebra.hpp"
#include "core/parallel.hpp"
#include "gap/compare/latent_bases.hpp"
#include "gap/filter/reference_units.hpp"
#include "gap/fit/coefficient_scale.hpp"
#include "gap/fit/levels.hpp"
#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

constexpr const ComparePolicy& kOf = kPolicy.compare;

double log_mean_exp(const std::vector<double>& x) {
  const double most = *std::ranges::max_element(x);
  double sum = 0.0;
  for (const double one : x) sum += std::exp(one - most);
  return most + std::log(sum / static_cast<double>(x.size()));
}

// The evidence about theta, the first `known`, where some columns with standard normal strengths times `size` act as
// well.
Evidence without_columns(const Evidence& all, Eigen::Index known, const std::vector<Eigen::Index>& columns,
                         double size) {
  Evidence result(known);
  result.measurements = all.measurements;
  const auto n = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd M = size * size * all.F(columns, columns);
  M.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> factor(M);
  const Eigen::VectorXd b = size * all.b(columns);
  const Eigen::MatrixXd cross = size * all.F.topRows(known)(Eigen::indexing::all, columns);
  const Eigen::MatrixXd solved = factor.solve(cross.transpose());
  result.b = all.b.head(known) - solved.transpose() * b;
  result.F = all.F.topLeftCorner(known, known) - cross * solved;
  result.log_likelihood = all.log_likelihood + 0.5 * b.dot(factor.solve(b)) -
                          (n > 0 ? factor.matrixLLT().diagonal().array().log().sum() : 0.0);
  return result;
}

// A share of the model error of a fit on each axis, with or without the events.
struct ModelError {
  Vec3<double> share = Vec3<double>::Ones();
  bool knows_events = true;
};

class Search {
 public:
  Search(const Campaign& campaign, const FittedNull& fit, std::size_t jobs)
      : fit_(fit),
        unit_(reference_acceleration(campaign.ship)),
        widths_(widths_by_scale(fit.stated, fit.parameters, fit.effects)),
        jobs_(jobs) {
    LatentBasis nothing;
    nothing.values.resize(fit.stretches.size());
    for (const bool knows_events : {true, false}) {
      const ModelError error{Vec3<double>::Ones(), knows_events};
      none_ = std::max(none_, evidence_with(nothing, {}, parts(nothing, error), error));
    }
  }

  /// Evidence of each stretch about theta and the columns.
  std::vector<Evidence> parts(const LatentBasis& basis, const ModelError& error) const {
    Noise noise = fit_.noise;
    noise.knows_events = error.knows_events;
    // Not below the least that is told from none: what is less is less without a force, too.
    for (int axis = 0; axis < 3; ++axis)
      if (error.share[axis] < 1.0)
        noise.sigma_w[axis] = std::max(error.share[axis] * noise.sigma_w[axis], noise.least_sigma_w[axis]);
    const Eigen::Index count = basis.columns;
    std::vector<Evidence> result(fit_.stretches.size());
    parallel_for(result.size(), jobs_, [&](std::size_t s) {
      const LinearStretch& stretch = fit_.stretches[s];
      result[s] = evidence(stretch, noise, count, [&](std::size_t k, Eigen::Ref<Eigen::MatrixXd> out) {
        out.noalias() = stretch.steps[k].A.middleCols<3>(kErrorStart) *
                        (unit_.asDiagonal() * basis.values[s].middleCols(static_cast<Eigen::Index>(k) * count, count));
      });
    });
    return result;
  }

  /// What a variant gains, averaged over sizes.
  double gain(const LatentBasis& basis, const LatentVariant& variant, const std::vector<Evidence>& parts,
              const ModelError& error) const {
    return evidence_with(basis, variant, parts, error) - none_;
  }
  double gain(const LatentBasis& basis, const LatentVariant& variant, const ModelError& error) const {
    return gain(basis, variant, parts(basis, error), error);
  }

 private:
  double evidence_with(const LatentBasis& basis, const LatentVariant& variant, const std::vector<Evidence>& parts,
                       const ModelError& error) const {
    const Eigen::Index known = fit_.theta.size();
    std::vector<Eigen::Index> columns = variant.columns;
    for (Eigen::Index& column : columns) column += known;
    Evidence together(known + basis.columns);
    for (const Evidence& part : parts) together += part;
    std::vector<double> by_size;
    for (const double size : kOf.latent_sizes) {
      Evidence total(known);
      if (basis.is_of_recording)
        for (const Evidence& part : parts) total += without_columns(part, known, columns, size);
      else
        total = without_columns(together, known, columns, size);
      // Coefficients that stood in for it may be as stated beside it.
      by_size.push_back(file_evidence(total, fit_.theta, widths_).log_evidence);
    }
    return log_mean_exp(by_size) + (error.knows_events ? fit_.log_prior_of_events : 0.0);
  }

  const FittedNull& fit_;
  Vec3<double> unit_;
  std::vector<PriorWidths> widths_;
  std::size_t jobs_;
  double none_ = -std::numeric_limits<double>::infinity();
};

struct TriedVariant {
  std::size_t basis;
  LatentVariant variant;
  LatentForce force;  // as it is told
  double gain;
};

// Of one kind: each basis as likely as another, and in each its variants.
double evidence_of_kind(const std::vector<TriedVariant>& all) {
  std::map<std::size_t, std::vector<double>> by_basis;
  for (const TriedVariant& one : all) by_basis[one.basis].push_back(one.gain);
  std::vector<double> gains;
  gains.reserve(by_basis.size());
  for (const auto& [basis, of_variants] : by_basis) gains.push_back(log_mean_exp(of_variants));
  return log_mean_exp(gains);
}

}  // namespace

std::vector<LatentForce> latent_forces(const Campaign& campaign, const FittedNull& fit, std::size_t jobs) {
  const Moments moments = moments_of(fit);
  if (std::ranges::all_of(moments, &std::vector<Moment>::empty)) return {};
  const std::vector<std::function<LatentBasis()>> bases = latent_bases(campaign, fit, moments);
  const Search search(campaign, fit, jobs);
  std::map<Dependence, std::vector<TriedVariant>> tried;
  for (std::size_t b = 0; b < bases.size(); ++b) {
    const LatentBasis basis = bases[b]();
    const std::vector<Evidence> parts = search.parts(basis, {});
    for (const LatentVariant& variant : basis.variants)
      tried[basis.on].push_back(
          {b,
           variant,
           {basis.on, variant.axes, basis.argument, basis.rings, basis.states, 0.0, variant.about},
           search.gain(basis, variant, parts, {})});
  }
  std::vector<LatentForce> result;
  for (auto& [on, all] : tried) {
    std::ranges::sort(all, std::greater(), &TriedVariant::gain);
    // With a force of its own the everyday model error is smaller, on each axis by as much as that took of it, and
    // what seemed events may be none.
    for (std::size_t i = 0; i < std::min(all.size(), kOf.latent_leading); ++i) {
      TriedVariant& one = all[i];
      const LatentBasis basis = bases[one.basis]().of(one.variant);
      const LatentVariant& variant = basis.variants.front();
      one.gain = std::max(one.gain, search.gain(basis, variant, {Vec3<double>::Ones(), false}));
      ModelError error;
      for (const int axis : variant.axes) {
        double likeliest = 1.0;
        for (const double share : kOf.latent_errors) {
          error.share[axis] = share;
          if (const double gain = search.gain(basis, variant, error); gain > one.gain)
            one.gain = gain, likeliest = share;
        }
        error.share[axis] = likeliest;
      }
    }
    result.push_back(std::ranges::max_element(all, {}, &TriedVariant::gain)->force);
    result.back().log_evidence = evidence_of_kind(all);
  }
  std::ranges::sort(result, std::greater(), &LatentForce::log_evidence);
  return result;
}

}  // namespace leeway::gap
