#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gap/policy/policy.hpp"
#include "gap/result/sensor_findings.hpp"
#include "gap/sensors/froude_scale.hpp"
#include "recording/trajectory.hpp"

namespace leeway::gap {

struct AuditOptions {
  FroudeScale scale;  ///< of the ship
  double false_alarm =
      kPolicy.detect.false_alarm;  ///< rate of finding a fault where there is none, over the whole library
  std::size_t jobs = 1;
  std::uint64_t seed = 1;
};

/// Compares the recordings with themselves, without any force model: over windows the integrals of eta' - R(psi) nu and
/// psi' - r, against each fault of the library, robustly, with rivalry between them. What is not recorded is said in
/// the notices. Formulas, signs and thresholds: docs/gap-audit.md.
Audit audit(const std::vector<Trajectory>& recordings, const AuditOptions& options);

/// That a fault's rivals fit almost as well, for the notices; nothing where it has none.
std::optional<std::string> rivals_notice(const Fault& fault);

/// Says a fault's sentence anew, after its numbers have changed.
void rephrase(Fault& fault);

/// The recording without the faults: channels shifted by fractions of a sample, rotated, rescaled. Samples that
/// a shift moves beyond the end become missing.
Trajectory corrected(const Trajectory& recording, const std::vector<Fault>& faults, const FroudeScale& scale);

}  // namespace leeway::gap
