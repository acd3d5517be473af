#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "gap/filter/campaign.hpp"
#include "gap/fit/null_fit.hpp"
#include "gap/locate/patterns.hpp"
#include "gap/result/latent_force.hpp"

namespace leeway::gap {

/// Columns of a basis that act together, and the axes of the ship on which they do.
struct LatentVariant {
  std::vector<Eigen::Index> columns;
  std::vector<int> axes;
  std::optional<Vec2<double>> about{};  ///< as LatentForce has it
};

/// Columns of accelerations in units of reference_acceleration(), of which one variant or another may act.
struct LatentBasis {
  Dependence on = Dependence::place;
  double argument = kMissing;    ///< as LatentForce has it
  bool is_of_recording = false;  ///< whether each stretch has strengths of its own
  bool rings = false;
  std::vector<Channel> states{};
  Eigen::Index columns = 0;
  std::vector<LatentVariant> variants{};
  std::vector<Eigen::MatrixXd> values{};  ///< by stretch: 3 x (steps * columns)

  /// With the columns of a variant alone.
  LatentBasis of(const LatentVariant& variant) const;
};

using Moments = std::vector<std::vector<Moment>>;  ///< by stretch and step
Moments moments_of(const FittedNull& fit);

/// How each basis is made: together they would take more memory than a workstation has. They refer to `moments`.
std::vector<std::function<LatentBasis()>> latent_bases(const Campaign& campaign, const FittedNull& fit,
                                                       const Moments& moments);

}  // namespace leeway::gap
