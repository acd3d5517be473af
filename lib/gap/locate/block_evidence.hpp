#pragma once

#include <string>
#include <vector>

#include "gap/fit/null_fit.hpp"

/// What recordings say about accelerations and module gains that are constant over blocks of time.
namespace leeway::gap {

/// Points [begin, end) of a stretch.
struct Block {
  std::size_t stretch, begin, end;
};

/// A force module, and the simulator with a gain of 1 + LocatePolicy::gain_step on it.
struct Module {
  std::string name;
  Model<double> scaled;
};

/// The modules of the ship; wind only where it is recorded, and none with an ensemble.
std::vector<Module> modules_of(const Campaign& campaign, const FittedNull& fit);

/// Scores of all blocks: column = block * kinds + kind; kinds are the accelerations on the three axes, in units of
/// reference_acceleration(), and the modules' gains.
struct BlockEvidence {
  std::vector<Block> blocks;
  int kinds = 0;
  Eigen::VectorXd b;
  Eigen::MatrixXd F;        ///< of b, when the parameters have taken what they can
  Eigen::MatrixXd F_given;  ///< about accelerations and gains, at the fitted parameters
  Eigen::Index column(std::size_t block, int kind) const { return static_cast<Eigen::Index>(block) * kinds + kind; }
};

/// By the everyday model error, so that events stand out, and what an ensemble was not trained for.
BlockEvidence block_evidence(const Campaign& campaign, const FittedNull& fit, const std::vector<Module>& modules,
                             std::size_t jobs);

}  // namespace leeway::gap
