#pragma once

#include <span>
#include <string>
#include <string_view>

namespace leeway::estimate {

/// The numbers that regressions of hull forces ask for. Lengths by L_pp, areas by L_pp d, as the coefficients.
struct HullForm {
  double C_b;
  double L_by_B, B_by_d, L_by_d;
  double x_G;  ///< by L_pp
  double m;    ///< m/(0.5 rho L^2 d) = 2 C_b B/L

  double c() const { return C_b / L_by_B; }  ///< C_b B/L
  double k() const { return 2.0 / L_by_d; }  ///< 2 d/L
};

/// What a formula was made from, of one parameter: "C_b", "L/B", "B/d", "C_P", "Fr", "aspect ratio", "P/D", "A_E/A_0",
/// "blades".
struct ParameterRange {
  std::string_view parameter;
  double low, high;
};

/// A published formula, or set of them, and the range that it was made for, as far as its authors say it.
struct FormulaRange {
  std::string_view source;
  std::span<const ParameterRange> parameters = {};  ///< none: no published range is known

  /// "C_b 0.5 to 0.85, L/B 4.5 to 7.5", or that none is known.
  std::string text() const;
  /// The source with its range in square brackets.
  std::string cited() const;
};
extern const FormulaRange kKijima, kClarke, kClarkeSurge, kLee, kYoshimura, kZhou, kSoeding;  // hull
extern const FormulaRange kHoltrop, kWageningen, kStandard, kFujii, kQuadvlieg, kHirano;      // resistance and stern
extern const FormulaRange kAlexander, kSchneekluth, kTankerPropeller, kContainerPropeller, kRudderArea, kFujiwara;
/// All of them.
std::span<const FormulaRange* const> all_formulas();

/// Linear derivatives in MMG's form: 0.5 rho L d U^2, of midship, without added mass.
struct LinearDerivatives {
  double Y_v, Y_r, N_v, N_r;
};
LinearDerivatives linear_by_kijima(const HullForm& hull, double m_x);
LinearDerivatives linear_by_clarke(const HullForm& hull);
LinearDerivatives linear_by_lee(const HullForm& hull, double m_x);

/// The further terms of the MMG standard method, by Yoshimura & Masumoto (2012).
struct FurtherDerivatives {
  double X_vv, X_vr, X_rr, X_vvvv, Y_vvv, Y_vvr, Y_vrr, Y_rrr, N_vvv, N_vvr, N_vrr, N_rrr;
};
FurtherDerivatives further_by_yoshimura(const HullForm& hull, double m_y);
/// Y_vvr by Lee et al. (1998), the one of their further terms that agrees in form and could be read.
double Y_vvr_by_lee(const HullForm& hull);

/// Added mass, in the same scales as m, and J_z by 0.5 rho L^4 d.
double m_x_by_clarke(const HullForm& hull);
double m_x_by_soeding(const HullForm& hull);
double m_y_by_zhou(const HullForm& hull);
double m_y_by_clarke(const HullForm& hull);
double J_z_by_zhou(const HullForm& hull);
double J_z_by_clarke(const HullForm& hull);

/// Interaction of hull and rudder.
double t_R_by_yoshimura();
double t_R_by_kijima(const HullForm& hull);
double a_H_by_yoshimura(const HullForm& hull);
double a_H_by_quadvlieg(const HullForm& hull);
double x_H_by_yoshimura();
double x_H_by_hirano(const HullForm& hull);
double gamma_R_by_yoshimura(const HullForm& hull);
double epsilon_by_yoshimura(double w_P0);
double f_alpha_by_fujii(double aspect_ratio);
double w_P0_by_yoshimura(const HullForm& hull);

}  // namespace leeway::estimate
