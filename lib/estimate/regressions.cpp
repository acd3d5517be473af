#include "estimate/regressions.hpp"

#include <cmath>

#include <fmt/format.h>

#include "core/units.hpp"

namespace leeway::estimate {

namespace {

constexpr ParameterRange kOfKijima[] = {{"C_b", 0.5, 0.85}, {"L/B", 4.5, 7.5}, {"B/d", 2.0, 5.0}},
                         kOfClarke[] = {{"C_b", 0.38, 0.89}, {"L/B", 3.9, 10.0}, {"B/d", 1.9, 8.0}},
                         kOfLee[] = {{"C_b", 0.5, 0.9}, {"L/B", 4.5, 8.0}, {"B/d", 2.0, 5.0}},
                         kOfYoshimura[] = {{"C_b", 0.5, 0.85}, {"L/B", 2.5, 7.5}, {"B/d", 2.0, 4.0}},
                         kOfZhou[] = {{"C_b", 0.5, 0.85}, {"L/B", 4.0, 9.0}, {"B/d", 2.0, 5.0}},
                         kOfHoltrop[] = {{"Fr", 0.0, 0.45}, {"C_P", 0.55, 0.85}, {"L/B", 3.9, 9.5}, {"B/d", 2.1, 4.0}},
                         kOfWageningen[] = {{"blades", 2.0, 7.0}, {"A_E/A_0", 0.3, 1.05}, {"P/D", 0.5, 1.4}},
                         kOfFujii[] = {{"aspect ratio", 0.5, 3.0}};

}  // namespace

const FormulaRange kKijima{"Kijima, Katsuno, Nakiri & Furukawa (1990), J. SNAJ 168, 247-257", kOfKijima};
const FormulaRange kClarke{"Clarke, Gedling & Hine (1983), Trans. RINA 125, 45-68", kOfClarke};
const FormulaRange kClarkeSurge{"5 % of m, Clarke, Gedling & Hine (1983)", kOfClarke};
const FormulaRange kLee{"Lee et al. (1998), as in Sukas, Kinaci & Bal (2019), Ocean Engineering 192, 106239", kOfLee};
const FormulaRange kYoshimura{"Yoshimura & Masumoto (2012), MARSIM", kOfYoshimura};
const FormulaRange kZhou{"Zhou, Sheng & Feng (1983), regression of Motora's charts", kOfZhou};
const FormulaRange kSoeding{"Soeding (1982), 2.7 rho V^(5/3)/L^2, as in Fossen (2021)"};
const FormulaRange kHoltrop{"Holtrop & Mennen (1982), Int. Shipbuilding Progress 29, 166-170, friction by ITTC 1957",
                            kOfHoltrop};
const FormulaRange kWageningen{"Wageningen B series, Oosterveld & van Oossanen (1975)", kOfWageningen};
const FormulaRange kStandard{"Yasukawa & Yoshimura (2015), JMST 20, 37-52"};
const FormulaRange kFujii{"Fujii & Tuda (1961), 6.13 A/(A + 2.25) by the aspect ratio A", kOfFujii};
const FormulaRange kQuadvlieg{"Quadvlieg (2013), 0.627 C_b - 0.153"};
const FormulaRange kHirano{"Hirano (1980), -(0.4 + 0.1 C_b)"};
const FormulaRange kAlexander{"Alexander's formula, C_b = 1.08 - 1.68 Fr"};
const FormulaRange kSchneekluth{
    "center of buoyancy 20 (C_b - 0.675) % of L ahead of midship, Schneekluth & Bertram (1998)"};
const FormulaRange kTankerPropeller{"0.395 d + 1.30 m of a tanker or bulk carrier, Kristensen & Lützen (2012)"};
const FormulaRange kContainerPropeller{"0.623 d - 0.16 m of a container ship, Kristensen & Lützen (2012)"};
const FormulaRange kRudderArea{"Det Norske Veritas' minimum, L d/100 (1 + 25 (B/L)^2)"};
const FormulaRange kFujiwara{"Fujiwara, Ueno & Nimura (1998), J. SNAJ 183, 77-90"};

std::span<const FormulaRange* const> all_formulas() {
  static constexpr const FormulaRange* kAll[] = {&kKijima,
                                                 &kClarke,
                                                 &kLee,
                                                 &kYoshimura,
                                                 &kZhou,
                                                 &kSoeding,
                                                 &kHoltrop,
                                                 &kWageningen,
                                                 &kStandard,
                                                 &kFujii,
                                                 &kQuadvlieg,
                                                 &kHirano,
                                                 &kAlexander,
                                                 &kSchneekluth,
                                                 &kTankerPropeller,
                                                 &kContainerPropeller,
                                                 &kRudderArea,
                                                 &kFujiwara};
  return kAll;
}

std::string FormulaRange::text() const {
  if (parameters.empty()) return "no published range known";
  std::string text;
  for (const ParameterRange& p : parameters)
    text += fmt::format("{}{} {:g} to {:g}", text.empty() ? "" : ", ", p.parameter, p.low, p.high);
  return text;
}

std::string FormulaRange::cited() const { return fmt::format("{} [{}]", source, text()); }

// k = 2 d/L, c = C_b B/L; Y_r and N_r of a ship on even keel.
LinearDerivatives linear_by_kijima(const HullForm& h, double m_x) {
  const double k = h.k(), c = h.c();
  return {-(0.5 * kPi * k + 1.4 * c), m_x + 0.5 * c, -k, -0.54 * k + k * k};
}

// By pi (d/L)^2 in the source, of 0.5 rho L^2 U^2.
LinearDerivatives linear_by_clarke(const HullForm& h) {
  const double s = kPi / h.L_by_d, B_by_L = 1.0 / h.L_by_B;
  return {-s * (1.0 + 0.4 * h.C_b * h.B_by_d), -s * (-0.5 + 2.2 * B_by_L - 0.08 * h.B_by_d),
          -s * (0.5 + 2.4 / h.L_by_d), -s * (0.25 + 0.039 * h.B_by_d - 0.56 * B_by_L)};
}

// The source's Y_r holds -(m + m_x).
LinearDerivatives linear_by_lee(const HullForm& h, double m_x) {
  const double b = h.C_b * h.B_by_d;
  return {-0.4545 + 0.065 * b, h.m + m_x - 0.115 * b + 0.0024 * h.L_by_d, -0.23 + 0.0059 * h.L_by_d,
          -0.003724 * h.L_by_d + 0.10446 - 1.393 / h.L_by_d};
}

// Y_vvv and N_vrr: public codes disagree about one sign of each; these agree with the measured hulls.
FurtherDerivatives further_by_yoshimura(const HullForm& h, double m_y) {
  const double c = h.c(), fine = (1.0 - h.C_b) * h.L_by_B;
  FurtherDerivatives f{};
  f.X_vv = 1.15 * c - 0.18;
  f.X_vr = m_y - 1.91 * c + 0.08;
  f.X_rr = -0.085 * c + 0.008 - h.x_G * m_y;
  f.X_vvvv = -6.68 * c + 1.1;
  f.Y_vvv = -(0.185 * h.L_by_B + 0.48);
  f.Y_vvr = -0.75;
  f.Y_vrr = -(0.26 * fine + 0.11);
  f.Y_rrr = -0.051;
  f.N_vvv = -(-0.69 * h.C_b + 0.66);
  f.N_vvr = 1.55 * c - 0.76;
  f.N_vrr = -(0.075 * fine - 0.098);
  f.N_rrr = 0.25 * c - 0.056;
  return f;
}

double Y_vvr_by_lee(const HullForm& h) { return 0.1234 * h.c() - 0.001452 * h.L_by_d; }

double m_x_by_clarke(const HullForm& h) { return 0.05 * h.m; }

// 2.7 rho V^(5/3)/L^2.
double m_x_by_soeding(const HullForm& h) {
  const double volume = 0.5 * h.m / h.L_by_d;  // by L^3
  return 2.7 * std::pow(volume, 5.0 / 3.0) / (0.5 / h.L_by_d);
}

double m_y_by_zhou(const HullForm& h) {
  const double d_by_B = 1.0 / h.B_by_d, slender = h.L_by_B * d_by_B;
  return h.m * (0.882 - 0.54 * h.C_b * (1.0 - 1.6 * d_by_B) - 0.156 * (1.0 - 0.673 * h.C_b) * h.L_by_B +
                0.826 * slender * (1.0 - 0.678 * d_by_B) - 0.638 * h.C_b * slender * (1.0 - 0.669 * d_by_B));
}

double m_y_by_clarke(const HullForm& h) {
  const double B_by_L = 1.0 / h.L_by_B;
  return kPi / h.L_by_d * (1.0 + 0.16 * h.C_b * h.B_by_d - 5.1 * B_by_L * B_by_L);
}

double J_z_by_zhou(const HullForm& h) {
  const double radius = 0.01 * (33.0 - 76.85 * h.C_b * (1.0 - 0.784 * h.C_b) + 3.43 * h.L_by_B * (1.0 - 0.63 * h.C_b));
  return h.m * radius * radius;
}

double J_z_by_clarke(const HullForm& h) {
  return kPi / h.L_by_d * (1.0 / 12.0 + 0.017 * h.C_b * h.B_by_d - 0.33 / h.L_by_B);
}

double t_R_by_yoshimura() { return 0.39; }
double t_R_by_kijima(const HullForm& h) { return 1.0 - (0.28 * h.C_b + 0.55); }
double a_H_by_yoshimura(const HullForm& h) { return 3.6 * h.c(); }
double a_H_by_quadvlieg(const HullForm& h) { return 0.627 * h.C_b - 0.153; }
double x_H_by_yoshimura() { return -0.4; }
double x_H_by_hirano(const HullForm& h) { return -(0.4 + 0.1 * h.C_b); }
double gamma_R_by_yoshimura(const HullForm& h) { return 2.06 * h.c() + 0.14; }
double epsilon_by_yoshimura(double w_P0) { return 2.26 - 1.82 * (1.0 - w_P0); }
double f_alpha_by_fujii(double aspect_ratio) { return 6.13 * aspect_ratio / (aspect_ratio + 2.25); }
double w_P0_by_yoshimura(const HullForm& h) { return 0.5 * h.C_b - 0.05; }

}  // namespace leeway::estimate
