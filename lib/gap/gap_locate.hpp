#pragma once

#include "gap/correct/investigation.hpp"
#include "recording/origin.hpp"

namespace leeway::gap {

/// Positions on a far grid are counted from near the recordings from now on; from where, or nothing where they are
/// near.
std::optional<Origin> count_from_near(const Ship& ship, std::vector<Trajectory>& recordings);

/// All of gap-locate: conventions, audit of the sensors, fit within the stated uncertainty, detection, location.
/// `recordings` are corrected in place where faults are found. Throws InputError for recordings that cannot be used.
Findings gap_locate(const Ship& ship, std::vector<Trajectory>& recordings, const GapLocateOptions& options);

/// The same with a trained ensemble as the simulator. Intervals in which it was not trained are called so and are no
/// mismatch; conventions are checked by kinematics alone, and known effects are those of EffectLibrary for an ensemble.
Findings gap_locate(const std::shared_ptr<const EnsembleSimulator>& ensemble, std::vector<Trajectory>& recordings,
                    const GapLocateOptions& options);

/// The same with what it is based on; `grossly_inconsistent` is not known yet.
Investigation investigate(const Ship& ship, std::vector<Trajectory>& recordings, const GapLocateOptions& options);

}  // namespace leeway::gap
