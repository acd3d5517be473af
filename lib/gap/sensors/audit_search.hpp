#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/random.hpp"
#include "gap/policy/policy.hpp"
#include "gap/sensors/audit.hpp"
#include "gap/sensors/audit_fitter.hpp"

namespace leeway::gap {

/// The gain in held-out log-likelihood of one fit over another: sum over what was left out in turn, and its standard
/// error.
struct HeldoutGain {
  double sum = 0.0, sd = 0.0;
  bool is_certain(double standard_errors = 2.0) const { return sum > standard_errors * sd && sum > 0.0; }
};
HeldoutGain heldout_gain(const FaultFit& better, const FaultFit& worse);

/// Student's p-value, of a gain that large where there is none. Scores say little of a fault where others have taken
/// what is linear in it.
double chance_of(const HeldoutGain& gain, std::size_t units);

/// Whether there are enough windows of a kind to be checked.
bool has_enough(const KinematicWindows& windows, Kinematics kind);

/// Candidates of the library beside faults that are known, and which of them is the next.
class FaultSearch {
 public:
  FaultSearch(const FaultFitter& fitter, const AuditOptions& options);

  /// All that can be tested beside the members of `base`, each fitted with them.
  std::vector<FaultFit> tried(const FaultFit& base) const;
  /// Family-wise p-values of the tried against their common base.
  ///   stream  number of the random stream
  std::vector<double> p_values(const FaultFit& base, const std::vector<FaultFit>& tried, std::size_t stream) const;
  /// The best of the tried: by held-out likelihood, of those that are significant if any is; of variants of one name
  /// the simpler unless the other is clearly better.
  ///   p  of each
  std::size_t best(const std::vector<FaultFit>& tried, const std::vector<double>& p) const;
  /// Where the p-value is a tenth of the rate, one standard error is enough.
  bool predicts_better(const FaultFit& with, const FaultFit& base, double p) const;
  bool is_found(const FaultFit& with, const FaultFit& base, double p) const;
  /// Two faults can hide each other, as each is noise to the other: the last of `first` and one more, where each is
  /// found beside the other.
  std::optional<FaultFit> pair_with(const FaultFit& first, std::size_t stage) const;

 private:
  bool is_testable(std::size_t candidate) const;

  const FaultFitter& fitter_;
  const AuditOptions& options_;
};

/// The candidate that a fit took last.
const FaultCandidate& last_of(const FaultFit& fit);

}  // namespace leeway::gap
