#pragma once

#include <vector>

#include "gap/result/sensor_findings.hpp"
#include "gap/sensors/froude_scale.hpp"
#include "gap/sensors/reading_odds.hpp"

/// Readings that the kinematics contradict: no force is known here. Each returns the readings that it claims and notes
/// them in `result`.
namespace leeway::gap {

/// eta' against R(psi) nu and psi' against r.
Combination contradicted_by_motion(const std::vector<Trajectory>& recordings, const FroudeScale& scale,
                                   Conventions& result);

/// w'_A against R(psi)^T w_T + (u, v_m), where both winds are recorded.
Combination contradicted_by_winds(const std::vector<Trajectory>& recordings, Conventions& result);

}  // namespace leeway::gap
