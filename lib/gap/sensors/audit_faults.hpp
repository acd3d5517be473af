#pragma once

#include "gap/result/sensor_findings.hpp"
#include "gap/sensors/audit_fitter.hpp"
#include "gap/sensors/froude_scale.hpp"

/// What a fit found, as faults that a person reads.
namespace leeway::gap {

/// What faults are measured by, at the scale of the ship of 3 m.
struct Usual {
  double speed_mps = 0.0, rate_radps = 0.0, sample_s = 0.0;
};
/// The size of a fault by the smallest that matters.
///   numbers  SI, of a ship of 3 m, as the candidate has them
double size_by_smallest(const FaultCandidate& candidate, const Eigen::VectorXd& numbers, const Usual& usual);
/// The same of a member of a fit.
double size_by_smallest(const FaultFitter& fitter, const FaultFit& fit, std::size_t place);

/// One member of a fit as a fault of the report: numbers with standard deviations, at the scale of the ship, and a
/// sentence.
Fault fault_of(const FaultFitter& fitter, const FaultFit& fit, std::size_t place, const RandomStream& stream,
               const FroudeScale& scale);

}  // namespace leeway::gap
