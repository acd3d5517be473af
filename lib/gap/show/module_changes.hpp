#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "gap/fit/null_fit.hpp"
#include "gap/result/ship_file.hpp"

/// What fitted coefficients of one module change, in the quantities of the field: resistance, yaw damping, thrust.
namespace leeway::gap {

/// Where the recordings were made: root mean squares of motion, actuators and apparent wind.
struct UsualConditions {
  double u = 0.0, v = 0.0, r = 0.0;  ///< [m/s], [m/s], [rad/s]; u the mean
  Actuators<double> actuators;       ///< rudders and thrusters; of what drives the ship the mean
  double wind = 0.0;                 ///< apparent [m/s]; 0: none is recorded
};
UsualConditions usual_conditions(const Campaign& campaign, const std::vector<Smoothed>& smoothed);

/// Whether a coefficient belongs to a module: names begin with it.
bool is_of_module(const std::string& coefficient, const std::string& module);
/// The modules of a ship's coefficients, "inertia", "hull", ..., each once.
std::vector<std::string> modules_of(std::span<const UncertainParameter> coefficients);

/// The quantities of a module that differ between the ship as its file has it and with theta, the surest first;
/// intervals by the linear spread of theta's covariance.
///   theta, covariance  of the coefficients, which `parameters` begin with
std::vector<ModuleChange> module_changes(const Ship& ship, const std::string& module,
                                         const std::vector<UncertainParameter>& parameters,
                                         const Eigen::VectorXd& theta, const Eigen::MatrixXd& covariance,
                                         const UsualConditions& usual);

}  // namespace leeway::gap
