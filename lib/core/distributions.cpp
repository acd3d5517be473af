#include "core/distributions.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace leeway {
namespace {

constexpr double kManyDof = 1e6;  // as good as infinite

}  // namespace

double chi_squared_survival(double x, double dof) {
  if (!(x > 0.0)) return 1.0;
  return boost::math::cdf(boost::math::complement(boost::math::chi_squared(dof), x));
}

double f_survival(double x, double dof_1, double dof_2) {
  if (!(x > 0.0)) return 1.0;
  if (!(dof_2 < kManyDof)) return chi_squared_survival(x * dof_1, dof_1);
  return boost::math::cdf(boost::math::complement(boost::math::fisher_f(dof_1, dof_2), x));
}

double t_survival_two_sided(double x, double dof) {
  if (!(dof < kManyDof)) return normal_survival_two_sided(x);
  return 2.0 * boost::math::cdf(boost::math::complement(boost::math::students_t(dof), std::abs(x)));
}

double normal_survival_two_sided(double x) { return std::erfc(std::abs(x) / std::sqrt(2.0)); }

}  // namespace leeway
