#pragma once

#include <vector>

#include "gap/fit/null_fit.hpp"

/// The smoothed residual: what has to be added to the simulator.
namespace leeway::gap {

/// The inertia matrix at midship, of (u', v_m', r') to (X, Y, N) (kg, kg m, kg m^2).
Mat3<double> inertia_matrix(const Ship& ship);

/// Accelerations and forces along each recording; recordings without a stretch have none.
std::vector<Residual> residuals(const Campaign& campaign, const FittedNull& fit);

/// Accelerations at each step in units of reference_acceleration(): by stretch, 3 x steps.
std::vector<Eigen::Matrix3Xd> smoothed_residual(const Campaign& campaign, const FittedNull& fit);

}  // namespace leeway::gap
