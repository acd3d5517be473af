#pragma once

#include <string>
#include <vector>

#include "gap/filter/campaign.hpp"
#include "gap/fit/hypothesis.hpp"
#include "gap/result/explanation.hpp"

/// A current that varies with time (`varying-current`). What is fitted is its course in each recording, or in all
/// alike: a few cosines. What is reported is the path, and the process that makes such paths.
namespace leeway::gap {

/// The effect with its cosines free, over the time of the longest recording; believed of them before is what the
/// process does at the prior's typical standard deviation and time constant.
FreeEffect::Choice current_course(const Campaign& campaign);

/// The path of each recording under a fit.
///   mean, covariance  of the hypothesis's coordinates
std::vector<CurrentPath> current_paths(const Campaign& campaign, const Hypothesis& hypothesis,
                                       const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance);
/// Columns t_s, current_north_mps, current_east_mps and the standard deviations of both.
std::string path_text(const CurrentPath& path);

/// Standard deviation and time constant of the process, each with its 95 % interval: of all that the catalogue's bounds
/// leave possible, on a grid, by how probable they make the fitted courses, whatever was believed before: of a current
/// that turns within a minute or two the time constant is 3 sd off, and the standard deviation would be taken for more
/// than twice as large. Courses are independent of each other.
///   courses           effects, whose coordinates follow each other; none: what is believed before
///   mean, covariance  of the coordinates, as the recordings alone say
std::vector<FreeEffect::Parameter> current_process(const Ship& ship, const std::vector<FreeEffect>& courses,
                                                   const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance);

}  // namespace leeway::gap
