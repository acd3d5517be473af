#pragma once

#include <vector>

#include "gap/filter/state_space.hpp"
#include "gap/sensors/sensor_faults.hpp"

namespace leeway::gap {

/// What sensors with faults read while a ship goes along a path, less what sound ones would: the faults in the
/// measurement function, where likelihoods of all of them are of the same data. Between points the path is a cubic
/// spline, to a lag straight; before the first it goes on straight.
///   t_s     times of the points [s], rising
///   path    states (x0, y0 [m], psi [rad], u, v_m [m/s], r [rad/s], ...) at these
///   faults  SI; a lag below zero counts as none
/// Returns additions to the six measured values, one per point.
std::vector<Vec6> read_beside(const SensorFaults& faults, const std::vector<double>& t_s,
                              const std::vector<StateVector>& path);

}  // namespace leeway::gap
