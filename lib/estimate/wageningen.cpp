#include "estimate/wageningen.hpp"

#include <algorithm>
#include <cmath>

#include "core/linear_algebra.hpp"

namespace leeway::estimate {
namespace {

struct SeriesTerm {
  double C;
  int s, t, u, v;  // powers of J, P/D, A_E/A_0, Z
};
constexpr SeriesTerm kThrustTerms[] = {
    {0.00880496, 0, 0, 0, 0},   {-0.204554, 1, 0, 0, 0},    {0.166351, 0, 1, 0, 0},    {0.158114, 0, 2, 0, 0},
    {-0.147581, 2, 0, 1, 0},    {-0.481497, 1, 1, 1, 0},    {0.415437, 0, 2, 1, 0},    {0.0144043, 0, 0, 0, 1},
    {-0.0530054, 2, 0, 0, 1},   {0.0143481, 0, 1, 0, 1},    {0.0606826, 1, 1, 0, 1},   {-0.0125894, 0, 0, 1, 1},
    {0.0109689, 1, 0, 1, 1},    {-0.133698, 0, 3, 0, 0},    {0.00638407, 0, 6, 0, 0},  {-0.00132718, 2, 6, 0, 0},
    {0.168496, 3, 0, 1, 0},     {-0.0507214, 0, 0, 2, 0},   {0.0854559, 2, 0, 2, 0},   {-0.0504475, 3, 0, 2, 0},
    {0.010465, 1, 6, 2, 0},     {-0.00648272, 2, 6, 2, 0},  {-0.00841728, 0, 3, 0, 1}, {0.0168424, 1, 3, 0, 1},
    {-0.00102296, 3, 3, 0, 1},  {-0.0317791, 0, 3, 1, 1},   {0.018604, 1, 0, 2, 1},    {-0.00410798, 0, 2, 2, 1},
    {-0.000606848, 0, 0, 0, 2}, {-0.0049819, 1, 0, 0, 2},   {0.0025983, 2, 0, 0, 2},   {-0.000560528, 3, 0, 0, 2},
    {-0.00163652, 1, 2, 0, 2},  {-0.000328787, 1, 6, 0, 2}, {0.000116502, 2, 6, 0, 2}, {0.000690904, 0, 0, 1, 2},
    {0.00421749, 0, 3, 1, 2},   {0.0000565229, 3, 6, 1, 2}, {-0.00146564, 0, 3, 2, 2}};

}  // namespace

double wageningen_K_T(const SeriesPropeller& p, double J) {
  double sum = 0.0;
  for (const SeriesTerm& term : kThrustTerms)
    sum += term.C * std::pow(J, term.s) * std::pow(p.pitch_ratio, term.t) * std::pow(p.area_ratio, term.u) *
           std::pow(p.blades, term.v);
  return sum;
}

double wageningen_J_0(const SeriesPropeller& p) {
  double low = 0.0, high = 2.0;
  for (int i = 0; i < 60; ++i) {
    const double J = 0.5 * (low + high);
    (wageningen_K_T(p, J) > 0.0 ? low : high) = J;
  }
  return 0.5 * (low + high);
}

QuadraticThrust fit_quadratic(const SeriesPropeller& p) {
  constexpr int kPoints = 41;
  const double J_0 = wageningen_J_0(p);
  Eigen::Matrix<double, kPoints, 3> A;
  Eigen::Matrix<double, kPoints, 1> b;
  for (int i = 0; i < kPoints; ++i) {
    const double J = J_0 * i / (kPoints - 1);
    A.row(i) << 1.0, J, J * J;
    b(i) = wageningen_K_T(p, J);
  }
  const Eigen::Vector3d K_T = A.colPivHouseholderQr().solve(b);
  return {{K_T(0), K_T(1), K_T(2)}, (A * K_T - b).cwiseAbs().maxCoeff()};
}

}  // namespace leeway::estimate
