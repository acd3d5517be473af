#pragma once

#include <functional>

#include "gap/findings.hpp"
#include "gap/null_fit.hpp"

namespace leeway::gap {

struct GapLocateOptions {
  bool correct = true;        ///< take the faults that the audit finds out before the fit
  double false_alarm = 0.01;  ///< rate of a mismatch, of a fault and of an interval where there is none
  double step_s = 0.0;        ///< of the filter's grid; 0: chosen by the ship's length
  std::size_t jobs = 1;
  std::uint64_t seed = 1;
  std::function<void(double done, const std::string& note)> progress;  ///< done in 0..1
};

/// All of gap-locate: conventions, audit of the sensors, fit within the stated uncertainty, detection, location.
/// `recordings` are corrected in place where faults are found. Throws InputError for recordings that cannot be used.
Findings gap_locate(const Ship& ship, std::vector<Trajectory>& recordings, const GapLocateOptions& options);

/// The same with a trained ensemble as the simulator. Intervals in which it was not trained are called so and are no
/// mismatch; conventions are checked by kinematics alone, and known effects are those of EffectLibrary for an ensemble.
Findings gap_locate(const std::shared_ptr<const EnsembleSimulator>& ensemble, std::vector<Trajectory>& recordings,
                    const GapLocateOptions& options);

/// Whether parameters are so far off, and so much is left, that this may be another ship.
bool errs_grossly(const NullFit& fit);

/// The same with what it rests on, to go on from; `grossly_inconsistent` is not known yet.
struct Investigation {
  Findings findings;
  Campaign campaign;
  FittedNull null;  ///< its stretches refer to the campaign's
};
Investigation investigate(const Ship& ship, std::vector<Trajectory>& recordings, const GapLocateOptions& options);

}  // namespace leeway::gap
