#pragma once

#include "ship/ship.hpp"

namespace leeway {

/// A ship on a straight course in calm air: v_m = r = 0 by constraint, rudders amidships, thrusters idle. A single
/// screw or unequal rudders may need a small rudder angle to hold it; that angle's drag is not in here.
struct StraightRun {
  double u = 0.0, n = 0.0;                            ///< [m/s], [1/s]
  double X_P = 0.0, X_H = 0.0, X_R = 0.0, X_A = 0.0;  ///< propulsion, (1 - t_P) T; hull; rudders; air [N]
  double J = 0.0, one_minus_w_P = 1.0, K_T = 0.0;     ///< K_T and J: 0 where n = 0
};

/// The forces and the propeller's working point at surge `u` and revolutions `n`.
StraightRun straight_run(const Ship& ship, double u, double n);

/// Revolutions [1/s] that hold surge `u` [m/s] on a straight run; negative for a ship going astern. Throws
/// NumericalError if the propeller cannot do it within its actuator's limits.
double self_propulsion_n(const Ship& ship, double u);

/// The surge [m/s] that a ship coming from rest reaches in the end on a straight run with revolutions `n`. Throws
/// NumericalError if there is none below Fr = 2.
double steady_speed(const Ship& ship, double n);

}  // namespace leeway
