#pragma once

#include <string>
#include <vector>

namespace leeway::estimate {

/// What the method asks for. Lengths [m], lcb in % of L forward of L/2, speed [m/s].
struct HoltropHull {
  double L = 0.0, B = 0.0, T_F = 0.0, T_A = 0.0;
  double volume = 0.0;  ///< [m^3]
  double lcb = 0.0;
  double C_M = 0.0, C_WP = 0.0;
  double A_BT = 0.0, h_B = 0.0;  ///< transverse area of the bulb [m^2], height of its center above the keel
  double A_T = 0.0;              ///< immersed transom [m^2]
  double C_stern = 0.0;          ///< -10: V sections, 10: U sections with Hogner stern
  double wetted_surface = 0.0;   ///< [m^2]; 0: by the method's own regression
  double rho = 1025.0, nu = 1.1883e-6;
  bool has_allowance = true;  ///< the correlation allowance C_A of a ship, which a model does not have

  double T() const { return 0.5 * (T_F + T_A); }
  double C_P() const { return volume / (C_M * B * T() * L); }
  double C_B() const { return volume / (L * B * T()); }
};

/// Resistance in calm water, without appendages.
/// Source: Holtrop & Mennen (1982), An approximate power prediction method, Int. Shipbuilding Progress 29, 166-170; the
/// friction line is ITTC 1957.
struct HoltropResistance {
  double S;                         ///< wetted surface [m^2]
  double C_F, form_factor, C_A;     ///< form_factor is 1 + k_1
  double R_F, R_W, R_B, R_TR, R_A;  ///< [N]
  double total;                     ///< [N]: R_F (1 + k_1) + R_W + R_B + R_TR + R_A
};
HoltropResistance holtrop_resistance(const HoltropHull& hull, double speed);

/// What the method takes powers of and a hull fuller, or finer, than its data has below 0: held at a small number, so
/// that it has a value. "C_b of 0.92 (C_P 0.925) is too full: 1 - C_P - 0.0225 lcb is held at 0.02"; mostly none.
std::vector<std::string> holtrop_limits(const HoltropHull& hull);

/// Wake fraction and thrust deduction of a single screw of diameter D, same source.
double holtrop_wake(const HoltropHull& hull, double speed, double D);
double holtrop_thrust_deduction(const HoltropHull& hull, double D);

/// 0.075/(log10 Re - 2)^2.
double ittc_57(double reynolds);
/// 1 + k_1, same source.
double holtrop_form_factor(const HoltropHull& hull);
double holtrop_wetted_surface(const HoltropHull& hull);
/// Half angle of entrance [deg].
double holtrop_entrance(const HoltropHull& hull);

}  // namespace leeway::estimate
