#pragma once

#include <optional>
#include <vector>

#include "gap/compare/fitted.hpp"
#include "gap/filter/campaign.hpp"
#include "gap/show/maneuver_menu.hpp"

/// What a maneuver would record under each of several hypotheses, before it is sailed.
namespace leeway::gap {

/// A hypothesis as it would stand in a recording that nobody has seen: what differed between recordings is a draw from
/// what was known before, a tug that came once is gone.
struct Survivor {
  Hypothesis hypothesis;
  FittedNull fit;             ///< theta and what goes with it, without stretches
  Eigen::MatrixXd precision;  ///< of theta, as the recordings so far leave it
};

///   is_of_other_depth  the water is as deep as it is there, whatever it was in the recordings
Survivor survivor(const Fitted& fitted, const Campaign& campaign, bool is_of_other_depth);

/// Where, and with which instruments.
struct Site {
  Ship ship;  ///< with what is known of the water there
  Vec2<double> wind_mps;
  std::vector<Channel> recorded;  ///< of the measured ones
  double step_s = 0.0;            ///< of the filter's grid
  NextLimits limits;
};
/// As in the recordings so far, but for the limits.
Site site_of(const Campaign& campaign, const NextLimits& limits);

/// What a maneuver's recordings say of each hypothesis if each is true.
struct Prospect {
  double each_s = 0.0;                           ///< duration of a run within the limits
  std::vector<std::vector<Evidence>> evidences;  ///< by truth, then by hypothesis
};
/// Nothing where the ship cannot do it, or not there.
std::optional<Prospect> prospect(const MenuItem& item, const std::vector<Survivor>& survivors, const Site& site);

/// How far hypotheses are from each other after all these recordings, once their parameters have moved within what is
/// left of their uncertainty: twice the log-likelihood ratio, in both directions the same.
Eigen::MatrixXd squared_distances(const std::vector<Survivor>& survivors, const std::vector<const Prospect*>& recorded);

}  // namespace leeway::gap
