#include "gap/fit/coefficient_scale.hpp"

#include <cmath>
#include <limits>

#include "gap/policy/policy.hpp"

namespace leeway::gap {

PriorWidths widths_at(const std::vector<UncertainParameter>& parameters, Eigen::Index effects, double scale) {
  PriorWidths result{Eigen::VectorXd(static_cast<Eigen::Index>(parameters.size())), scale, 0.0};
  const Eigen::Index coefficients = result.sd.size() - 1 - effects;
  for (Eigen::Index i = 0; i < result.sd.size(); ++i)
    result.sd[i] = parameters[static_cast<std::size_t>(i)].sd * (i < coefficients ? scale : 1.0);
  return result;
}

std::vector<PriorWidths> widths_by_scale(const std::vector<UncertainParameter>& parameters, Eigen::Index effects) {
  constexpr const FitPolicy& of = kPolicy.fit;
  std::vector<PriorWidths> result;
  result.reserve(of.scales);
  double sum = 0.0;
  for (std::size_t i = 0; i < of.scales; ++i) {
    const double z = of.scale_reach_sd * (2.0 * static_cast<double>(i) / static_cast<double>(of.scales - 1) - 1.0);
    result.push_back(widths_at(parameters, effects, std::exp(of.scale_log_sd * z)));
    result.back().log_weight = -0.5 * z * z;
    sum += std::exp(result.back().log_weight);
  }
  for (PriorWidths& widths : result) widths.log_weight -= std::log(sum);
  return result;
}

OverScales over_scales(const Evidence& evidence, const Eigen::VectorXd& theta, const std::vector<PriorWidths>& widths) {
  OverScales result{-std::numeric_limits<double>::infinity(), widths.front()};
  double most = -std::numeric_limits<double>::infinity(), sum = 0.0;
  for (const PriorWidths& one : widths) {
    const double here = one.log_weight + marginal(evidence, theta, one.sd);
    if (!std::isfinite(here)) continue;
    if (here > most) {
      sum *= std::exp(most - here);
      most = here;
      result.likeliest = one;
    }
    sum += std::exp(here - most);
  }
  if (sum > 0.0) result.log_evidence = most + std::log(sum);
  return result;
}

}  // namespace leeway::gap
