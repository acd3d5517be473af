#pragma once

#include <vector>

#include "gap/result/sensor_findings.hpp"
#include "recording/trajectory.hpp"
#include "ship/ship.hpp"

namespace leeway::gap {

/// Enumerates sign, unit and frame readings of each channel and scores them by kinematic consistency (eta' against
/// R(psi) nu, psi' against r, true against apparent wind) and by gross force consistency (the ship's model against the
/// recorded velocities over short times). Nothing is fitted. Readings that the data do not distinguish from the stated
/// one are not claimed. Readings and thresholds: docs/gap-audit.md.
Conventions check_conventions(const Ship& ship, const std::vector<Trajectory>& recordings);
/// The same by kinematic consistency alone; of the ship its length is used.
Conventions check_motion(const Ship& ship, const std::vector<Trajectory>& recordings);
/// One recording that reads otherwise than all others: for each recording by itself the reading that fits best, where
/// it fits better than what is stated and the others refute it. With the others' word for the channel less is needed
/// than for all recordings together. At most one reading for a recording.
std::vector<Reading> contradicted_in_one(const Ship& ship, const std::vector<Trajectory>& recordings,
                                         const Conventions& of_all, std::size_t jobs);

/// The recording as it reads when the named readings hold that are for it: afterwards it follows leeway's conventions.
Trajectory reread(const Trajectory& recording, const std::vector<Reading>& readings);

}  // namespace leeway::gap
