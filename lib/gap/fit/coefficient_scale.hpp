#pragma once

#include <vector>

#include "gap/filter/uncertainty.hpp"
#include "gap/fit/levels.hpp"

/// How wrong a ship's file is about its coefficients. Each is as uncertain as the file states, times one scale c that
/// is common to all, ln c ~ N(0, 0.5^2): all coefficients together tell c, so that a file that is worse than it states
/// is no missing physics. Besides, with little probability, each is off by far more, whatever the others are: spike and
/// slab, and the slab is the only heavy tail.
namespace leeway::gap {

/// What is believed of theta at one value of the common scale.
struct PriorWidths {
  ThetaPrior prior;
  Eigen::VectorXd slab = {};  ///< sd of what is off by far more; 0: cannot be; empty: nothing can
  Eigen::VectorXd side = {};  ///< to which it may be: 1 more, -1 less, 0 both
  double scale = 1.0;
  double log_weight = 0.0;  ///< ln of the probability that the scale is this one
};

/// On nine values of the scale, from a fifth to four and a half times what is stated; weights sum to 1. theta =
/// (coefficients, numbers of faults, coordinates of effects, timing): the coefficients' widths times the scale, the
/// others as they are.
///   stated  of theta, as the ship's file has it
std::vector<PriorWidths> widths_by_scale(const ThetaPrior& stated, const std::vector<UncertainParameter>& parameters,
                                         Eigen::Index effects);

/// The same with standard normal coordinates inserted at a place of theta, which no slab has.
std::vector<PriorWidths> with_coordinates(std::vector<PriorWidths> widths, Eigen::Index place, Eigen::Index count);

/// What the evidence says of a file: marginal() averaged over the scale and over what may be off by far more.
struct FileEvidence {
  double log_evidence = 0.0;
  PriorWidths likeliest;  ///< at the likeliest scale; of what is off by far more, the precisions by their probabilities
  Eigen::VectorXd off;    ///< of theta: the probability that it is off by far more than stated
};
FileEvidence file_evidence(const Evidence& evidence, const Eigen::VectorXd& theta,
                           const std::vector<PriorWidths>& widths);

/// What recordings say of standard normal coordinates beside theta.
struct MoreCoordinates {
  Eigen::VectorXd z;           ///< where they are
  Eigen::VectorXd score;       ///< slope of the log-likelihood there
  Eigen::MatrixXd with_theta;  ///< its curvature, theta by them
  Eigen::MatrixXd own;         ///< the same among them
};

/// file_evidence() of theta with many sets of coordinates beside it: what does not depend on them is solved once.
class FileEvidenceBeside {
 public:
  ///   F  curvature of the log-likelihood by theta
  FileEvidenceBeside(const Eigen::MatrixXd& F, Eigen::VectorXd theta, std::vector<PriorWidths> widths);
  ///   score  slope of the log-likelihood by theta
  /// `likeliest` and `off` are those of theta.
  FileEvidence with(double log_likelihood, const Eigen::VectorXd& score, const MoreCoordinates& more) const;

 private:
  struct Alone {
    Eigen::MatrixXd covariance;
    double log_determinant;
  };
  Eigen::VectorXd theta_;
  std::vector<PriorWidths> widths_;
  std::vector<Alone> alone_;  // of theta without others, for each of the widths
};

}  // namespace leeway::gap
