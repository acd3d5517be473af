#pragma once

#include "gap/result/sensor_findings.hpp"
#include "gap/sensors/audit_fitter.hpp"
#include "gap/sensors/froude_scale.hpp"

/// What a fit found, as faults that a person reads.
namespace leeway::gap {

/// The size of a member's fault by the smallest that matters.
double size_by_smallest(const FaultFitter& fitter, const FaultFit& fit, std::size_t place);

/// One member of a fit as a fault of the report: numbers with standard deviations, at the scale of the ship, and a
/// sentence.
Fault fault_of(const FaultFitter& fitter, const FaultFit& fit, std::size_t place, const RandomStream& stream,
               const FroudeScale& scale);

}  // namespace leeway::gap
