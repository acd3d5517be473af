#pragma once

#include "gap/comparison.hpp"
#include "gap/explain.hpp"

namespace leeway::gap {

/// Which hypotheses were fitted, and what of them is claimed. Places are those of Comparison::all(); 0: nothing
/// missing.
struct Selection {
  std::vector<std::string> unexcited;  ///< effects of which these recordings say nothing
  std::vector<double> stated;          ///< probabilities when the choice was made
  std::size_t best = 0;                ///< likeliest of those that may be claimed, beside nothing missing
  std::size_t chosen = 0;              ///< what is claimed
  double left_p_value = 1.0;           ///< of what is left beside it
  bool is_negligible = false;          ///< whether that is not worth a word
  /// Model error beside what is claimed, by the typical acceleration, on the axis or in the interval where it is
  /// largest. Below kErrorOfForms it is what simulators leave that lack nothing: then nothing is called unknown.
  double error = 0.0;
};
inline constexpr double kErrorOfForms = 0.1;

/// Whether terms stand for what the catalogue does not hold.
bool has_terms(const std::vector<std::string>& names);

/// p-value below which what has no name is called unknown.
inline double surely(const GapExplainOptions& options) {
  return options.locate.false_alarm * options.locate.false_alarm;
}
/// The same beside what is named, whose form may be a little other than the catalogue's.
inline double surely_beside(const GapExplainOptions& options) { return surely(options) * surely(options); }

/// Fits the likeliest effects one by one, then pairs, places, a tug and terms of the unknown, and chooses: what is
/// stated as likeliest, then effects beside it while something is left, without those that the others have made
/// needless.
///   progress  from 0.45 to 0.88
Selection select(Campaign& campaign, const Findings& findings, Comparison& comparison,
                 const GapExplainOptions& options);

}  // namespace leeway::gap
