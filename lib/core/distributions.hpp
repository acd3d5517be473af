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

}  // namespace leeway
