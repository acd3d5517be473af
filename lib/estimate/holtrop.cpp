#include "estimate/holtrop.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/units.hpp"

namespace leeway::estimate {
namespace {

// What powers are taken of, as the formulas have it and held where it is too small: beyond the data (C_P 0.55 to 0.85)
// it becomes negative. Each bound is about that of a C_P of 0.9.
struct Base {
  const char* formula;
  double value, least;
  double held() const { return std::max(value, least); }
};
Base run(const HoltropHull& h) {  // length of run by L
  const double C_P = h.C_P();
  return {"the length of run by L", 1.0 - C_P + 0.06 * C_P * h.lcb / std::max(4.0 * C_P - 1.0, 0.2), 0.05};
}
Base forward(const HoltropHull& h) { return {"1 - C_P - 0.0225 lcb", 1.0 - h.C_P() - 0.0225 * h.lcb, 0.02}; }
Base aft(const HoltropHull& h) { return {"1 - C_P + 0.0225 lcb", 1.0 - h.C_P() + 0.0225 * h.lcb, 0.02}; }
Base fullness(const HoltropHull& h) { return {"0.95 - C_P", 0.95 - h.C_P(), 0.05}; }
Base block(const HoltropHull& h) { return {"0.95 - C_B", 0.95 - h.C_B(), 0.05}; }
Base stern(const HoltropHull& h) {  // 1 - C_P1
  return {"1.315 - 1.45 C_P + 0.0225 lcb", 1.315 - 1.45 * h.C_P() + 0.0225 * h.lcb, 0.05};
}

double L_R(const HoltropHull& h) { return h.L * run(h).held(); }

double c7(const HoltropHull& h) {
  const double x = h.B / h.L;
  if (x < 0.11) return 0.229577 * std::cbrt(x);
  return x < 0.25 ? x : 0.5 - 0.0625 / x;
}

double wave_resistance(const HoltropHull& h, double speed) {
  const double C_P = h.C_P(), T = h.T(), Fn = speed / std::sqrt(kGravity_mps2 * h.L), L3_V = h.L * h.L * h.L / h.volume;
  const double c1 = 2223105.0 * std::pow(c7(h), 3.78613) * std::pow(T / h.B, 1.07961) *
                    std::pow(90.0 - holtrop_entrance(h), -1.37565);
  const double c3 = 0.56 * std::pow(h.A_BT, 1.5) / (h.B * T * (0.31 * std::sqrt(h.A_BT) + h.T_F - h.h_B));
  const double c2 = std::exp(-1.89 * std::sqrt(c3)), c5 = 1.0 - 0.8 * h.A_T / (h.B * T * h.C_M);
  const double c16 =
      C_P < 0.8 ? 8.07981 * C_P - 13.8673 * C_P * C_P + 6.984388 * C_P * C_P * C_P : 1.73014 - 0.7067 * C_P;
  const double m1 = 0.0140407 * h.L / T - 1.75254 * std::cbrt(h.volume) / h.L - 4.79323 * h.B / h.L - c16;
  const double c15 = L3_V < 512.0 ? -1.69385 : L3_V > 1727.0 ? 0.0 : -1.69385 + (std::cbrt(L3_V) - 8.0) / 2.36;
  const double m2 = c15 * C_P * C_P * std::exp(-0.1 / (Fn * Fn));
  const double lambda = 1.446 * C_P - (h.L / h.B < 12.0 ? 0.03 * h.L / h.B : 0.36);
  return c1 * c2 * c5 * h.volume * h.rho * kGravity_mps2 *
         std::exp(m1 * std::pow(Fn, -0.9) + m2 * std::cos(lambda / (Fn * Fn)));
}

double bulb_resistance(const HoltropHull& h, double speed) {
  if (!(h.A_BT > 0.0)) return 0.0;
  const double P_B = 0.56 * std::sqrt(h.A_BT) / (h.T_F - 1.5 * h.h_B);
  const double F_ni =
      speed / std::sqrt(kGravity_mps2 * (h.T_F - h.h_B - 0.25 * std::sqrt(h.A_BT)) + 0.15 * speed * speed);
  return 0.11 * std::exp(-3.0 / (P_B * P_B)) * std::pow(F_ni, 3.0) * std::pow(h.A_BT, 1.5) * h.rho * kGravity_mps2 /
         (1.0 + F_ni * F_ni);
}

double transom_resistance(const HoltropHull& h, double speed) {
  if (!(h.A_T > 0.0)) return 0.0;
  const double F_nT = speed / std::sqrt(2.0 * kGravity_mps2 * h.A_T / (h.B + h.B * h.C_WP));
  return 0.5 * h.rho * speed * speed * h.A_T * (F_nT < 5.0 ? 0.2 * (1.0 - 0.2 * F_nT) : 0.0);
}

double allowance(const HoltropHull& h) {
  if (!h.has_allowance) return 0.0;
  const double c4 = std::min(h.T_F / h.L, 0.04), C_B = h.C_B();
  const double c3 = 0.56 * std::pow(h.A_BT, 1.5) / (h.B * h.T() * (0.31 * std::sqrt(h.A_BT) + h.T_F - h.h_B));
  const double c2 = std::exp(-1.89 * std::sqrt(c3));
  return 0.006 * std::pow(h.L + 100.0, -0.16) - 0.00205 +
         0.003 * std::sqrt(h.L / 7.5) * C_B * C_B * C_B * C_B * c2 * (0.04 - c4);
}

double C_P1(const HoltropHull& h) { return 1.0 - stern(h).held(); }

double c11(const HoltropHull& h, double D) {
  const double x = h.T_A / D;
  return x < 2.0 ? x : 0.0833333 * x * x * x + 1.33333;
}

}  // namespace

std::vector<std::string> holtrop_limits(const HoltropHull& h) {
  std::vector<std::string> limits;
  for (const Base& base : {run(h), forward(h), aft(h), fullness(h), block(h), stern(h)})
    if (base.value < base.least)
      limits.push_back(
          fmt::format("at a C_b of {:.3g} (C_P {:.3g}, 0.55 to 0.85 in the data) {} is {:.3g}, held at {:g}", h.C_B(),
                      h.C_P(), base.formula, base.value, base.least));
  return limits;
}

double ittc_57(double reynolds) {
  const double x = std::log10(reynolds) - 2.0;
  return 0.075 / (x * x);
}

double holtrop_wetted_surface(const HoltropHull& h) {
  if (h.wetted_surface > 0.0) return h.wetted_surface;
  return h.L * (2.0 * h.T() + h.B) * std::sqrt(h.C_M) *
             (0.453 + 0.4425 * h.C_B() - 0.2862 * h.C_M - 0.003467 * h.B / h.T() + 0.3696 * h.C_WP) +
         2.38 * h.A_BT / h.C_B();
}

double holtrop_entrance(const HoltropHull& h) {
  return 1.0 + 89.0 * std::exp(-std::pow(h.L / h.B, 0.80856) * std::pow(1.0 - h.C_WP, 0.30484) *
                               std::pow(forward(h).held(), 0.6367) * std::pow(L_R(h) / h.B, 0.34574) *
                               std::pow(100.0 * h.volume / (h.L * h.L * h.L), 0.16302));
}

double holtrop_form_factor(const HoltropHull& h) {
  const double x = h.T() / h.L;
  const double c12 = x > 0.05   ? std::pow(x, 0.2228446)
                     : x > 0.02 ? 48.20 * std::pow(x - 0.02, 2.078) + 0.479948
                                : 0.479948;
  const double c13 = 1.0 + 0.003 * h.C_stern;
  return c13 * (0.93 + c12 * std::pow(h.B / L_R(h), 0.92497) * std::pow(fullness(h).held(), -0.521448) *
                           std::pow(aft(h).held(), 0.6906));
}

HoltropResistance holtrop_resistance(const HoltropHull& h, double speed) {
  HoltropResistance r{};
  r.S = holtrop_wetted_surface(h);
  const double q = 0.5 * h.rho * speed * speed * r.S;
  r.C_F = ittc_57(speed * h.L / h.nu);
  r.form_factor = holtrop_form_factor(h);
  r.C_A = allowance(h);
  r.R_F = q * r.C_F;
  r.R_W = wave_resistance(h, speed);
  r.R_B = bulb_resistance(h, speed);
  r.R_TR = transom_resistance(h, speed);
  r.R_A = q * r.C_A;
  r.total = r.R_F * r.form_factor + r.R_W + r.R_B + r.R_TR + r.R_A;
  return r;
}

double holtrop_wake(const HoltropHull& h, double speed, double D) {
  const double x = h.B / h.T_A, S = holtrop_wetted_surface(h);
  const double c8 = x < 5.0 ? h.B * S / (h.L * D * h.T_A) : S * (7.0 * x - 25.0) / (h.L * D * (x - 3.0));
  const double c9 = c8 < 28.0 ? c8 : 32.0 - 16.0 / (c8 - 24.0);
  const double C_V = holtrop_form_factor(h) * ittc_57(speed * h.L / h.nu) + allowance(h);
  return c9 * C_V * h.L / h.T_A * (0.0661875 + 1.21756 * c11(h, D) * C_V / (1.0 - C_P1(h))) +
         0.24558 * std::sqrt(h.B / (h.L * (1.0 - C_P1(h)))) - 0.09726 / fullness(h).held() + 0.11434 / block(h).held() +
         0.75 * h.C_stern * C_V + 0.002 * h.C_stern;
}

double holtrop_thrust_deduction(const HoltropHull& h, double D) {
  const double c10 = h.L / h.B > 5.2 ? h.B / h.L : 0.25 - 0.003328402 / (h.B / h.L - 0.134615385);
  return 0.001979 * h.L / (h.B - h.B * C_P1(h)) + 1.0585 * c10 - 0.00524 - 0.1418 * D * D / (h.B * h.T()) +
         0.0015 * h.C_stern;
}

}  // namespace leeway::estimate
