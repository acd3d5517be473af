#include "core/distributions.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace leeway {
namespace {

constexpr double kManyDof = 1e6;  // as good as infinite

// P(a standard normal variable < x).
double normal_below(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

// The x of which this is the probability.
double normal_quantile(double below) {
  if (!(below > 0.0)) return -std::numeric_limits<double>::infinity();
  if (!(below < 1.0)) return std::numeric_limits<double>::infinity();
  return boost::math::quantile(boost::math::normal(), below);
}

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

double within_bounds(double z, double low, double high) {
  if (std::isinf(low) && std::isinf(high)) return z;
  if (z > 0.0) return -within_bounds(-z, -high, -low);  // the lower tail has all its digits
  const double cut = normal_below(low);
  return std::clamp(normal_quantile(cut + (normal_below(high) - cut) * normal_below(z)), low, high);
}

double without_bounds(double x, double low, double high) {
  if (std::isinf(low) && std::isinf(high)) return x;
  if (!(x > low)) return -std::numeric_limits<double>::infinity();
  if (!(x < high)) return std::numeric_limits<double>::infinity();
  if (x > 0.0) return -without_bounds(-x, -high, -low);
  const double cut = normal_below(low);
  return normal_quantile((normal_below(x) - cut) / (normal_below(high) - cut));
}

}  // namespace leeway
