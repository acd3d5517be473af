#pragma once

#include <map>
#include <string>
#include <vector>

#include "gap/result/explanation.hpp"

namespace leeway::gap {

/// How probably each effect and fault acts, and as "coefficient:hull.N_r" each coefficient is off by far more than the
/// ship file states: over all hypotheses, with what was screened beside them and not fitted. What is missing to 1 after
/// the probabilities were held against simulated campaigns is that of truths that were not fitted.
std::map<std::string, double> inclusion(const Explanation& explanation);

/// How probable all together is that was not fitted.
double not_fitted(const Explanation& explanation);

/// The name of a coefficient there.
std::string coefficient_in_inclusion(const std::string& name);

/// A set of effects and faults that may be what acts.
struct ProbableSet {
  std::vector<std::string> names;
  double probability = 0.0;
  bool is_credible = false;  ///< whether it is one of the fewest that hold 95 %
};
/// Most probable first: all that hypotheses were fitted of, and others that belong to the fewest that hold 95 %.
std::vector<ProbableSet> probable_sets(const Explanation& explanation);

}  // namespace leeway::gap
