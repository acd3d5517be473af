#include "gap/fit/coefficient_scale.hpp"

#include <cmath>
#include <limits>

#include "gap/policy/policy.hpp"

namespace leeway::gap {
namespace {

ScaledWidths widths_at(const FittedNull& fit, double scale) {
  ScaledWidths result{Eigen::VectorXd(fit.theta.size()), scale};
  const Eigen::Index coefficients = result.sd.size() - 1 - fit.effects;
  for (Eigen::Index i = 0; i < result.sd.size(); ++i)
    result.sd[i] = fit.parameters[static_cast<std::size_t>(i)].sd * (i < coefficients ? scale : 1.0);
  return result;
}

}  // namespace

ScaledWidths likeliest_widths(const FittedNull& fit) {
  constexpr const FitPolicy& of = kPolicy.fit;
  ScaledWidths likeliest = widths_at(fit, 1.0);
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < of.scales; ++i) {
    const double z = of.scale_reach_sd * (2.0 * static_cast<double>(i) / static_cast<double>(of.scales - 1) - 1.0);
    ScaledWidths one = widths_at(fit, std::exp(of.scale_log_sd * z));
    const double here = marginal(fit.total, fit.theta, one.sd) - 0.5 * z * z;
    if (!(here > most)) continue;
    most = here;
    likeliest = std::move(one);
  }
  return likeliest;
}

}  // namespace leeway::gap
