#pragma once

namespace leeway {

/// P(chi2 with `dof` degrees of freedom > x).
double chi_squared_survival(double x, double dof);

/// P(F with (dof_1, dof_2) degrees of freedom > x); dof_2 may be infinite.
double f_survival(double x, double dof_1, double dof_2);

/// P(Student's t with `dof` degrees of freedom > x in absolute value).
double t_survival_two_sided(double x, double dof);

/// P(|standard normal| > x).
double normal_survival_two_sided(double x);

/// The value of a normal variable cut off outside (low, high), in units of its sd from its median, below which it is
/// as often as a standard normal one is below `z`. The bounds, low < high, may be infinite.
double within_bounds(double z, double low, double high);

/// The z for which within_bounds(z, low, high) is `x`; infinite where `x` is not between the bounds.
double without_bounds(double x, double low, double high);

}  // namespace leeway
