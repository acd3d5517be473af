#include "gap/bootstrap/reliability.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

double powered(double probability, double sharpness) {
  return probability > 0.0 ? std::pow(probability, sharpness) : 0.0;
}

// ln of how likely the truths of the campaigns are, of those that were fitted, and of the sharpness itself.
double log_posterior(const Bootstrap& bootstrap, double log_sharpness) {
  const double z = log_sharpness / kPolicy.bootstrap.sharpness_log_sd, sharpness = std::exp(log_sharpness);
  double sum = -0.5 * z * z;
  for (const SimulatedAnswer& one : bootstrap.campaigns) {
    if (!(one.stated_of_truth > 0.0)) continue;
    double all = 0.0;
    for (const double p : one.stated) all += powered(p, sharpness);
    sum += sharpness * std::log(one.stated_of_truth) - std::log(all);
  }
  return sum;
}

}  // namespace

void fit_reliability(Bootstrap& bootstrap) {
  const auto missed = std::ranges::count_if(bootstrap.campaigns,
                                            [](const SimulatedAnswer& one) { return !(one.stated_of_truth > 0.0); });
  bootstrap.not_fitted = (static_cast<double>(missed) + 0.5) / (static_cast<double>(bootstrap.campaigns.size()) + 1.0);
  // ln p is a sum of logistic terms in the sharpness: one maximum, by golden sections.
  const double reach = kPolicy.bootstrap.sharpness_reach_sd * kPolicy.bootstrap.sharpness_log_sd;
  constexpr double share = std::numbers::phi - 1.0;
  double low = -reach, high = reach;
  while (high - low > kPolicy.bootstrap.sharpness_tolerance) {
    const double left = high - share * (high - low), right = low + share * (high - low);
    if (log_posterior(bootstrap, left) > log_posterior(bootstrap, right))
      high = right;
    else
      low = left;
  }
  bootstrap.sharpness = std::exp(0.5 * (low + high));
}

std::vector<double> as_realized(const Bootstrap& bootstrap, std::vector<double> stated) {
  double before = 0.0, after = 0.0;
  for (double& p : stated) {
    before += p;
    after += p = powered(p, bootstrap.sharpness);
  }
  if (after > 0.0)
    for (double& p : stated) p *= before * (1.0 - bootstrap.not_fitted) / after;
  return stated;
}

}  // namespace leeway::gap
