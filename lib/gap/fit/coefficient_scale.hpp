#pragma once

#include <vector>

#include "gap/filter/uncertainty.hpp"
#include "gap/fit/levels.hpp"

/// How wrong a ship's file is about its coefficients: each is as uncertain as the file states, times one scale c that
/// is common to all, ln c ~ N(0, 0.5^2). All coefficients together tell c, so that a file that is worse than it states
/// is no missing physics, and one coefficient far off alone is no worse file.
namespace leeway::gap {

/// Standard deviations of theta at one value of the common scale.
struct PriorWidths {
  Eigen::VectorXd sd;
  double scale = 1.0;
  double log_weight = 0.0;  ///< ln of the probability that the scale is this one
};

/// theta = (coefficients, coordinates of effects, timing): the coefficients' widths times the scale, the others as they
/// are.
PriorWidths widths_at(const std::vector<UncertainParameter>& parameters, Eigen::Index effects, double scale);

/// On nine values of the scale, from a fifth to four and a half times what is stated; weights sum to 1.
std::vector<PriorWidths> widths_by_scale(const std::vector<UncertainParameter>& parameters, Eigen::Index effects);

/// marginal() averaged over the scale, and the widths that make the evidence likeliest.
struct OverScales {
  double log_evidence = 0.0;
  PriorWidths likeliest;
};
OverScales over_scales(const Evidence& evidence, const Eigen::VectorXd& theta, const std::vector<PriorWidths>& widths);

}  // namespace leeway::gap
