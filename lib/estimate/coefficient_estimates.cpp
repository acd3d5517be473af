#include "estimate/coefficient_estimates.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

namespace leeway::estimate {
namespace {

constexpr std::string_view kHoltrop =
    "Holtrop & Mennen (1982), Int. Shipbuilding Progress 29, 166-170, friction by ITTC 1957";
constexpr std::string_view kStandard = "Yasukawa & Yoshimura (2015), JMST 20, 37-52";
constexpr std::string_view kSoeding = "Soeding (1982), 2.7 rho V^(5/3)/L^2, as in Fossen (2021)";
constexpr std::string_view kFujii = "Fujii & Tuda (1961), 6.13 A/(A + 2.25) by the aspect ratio A";
constexpr std::string_view kQuadvlieg = "Quadvlieg (2013), 0.627 C_b - 0.153";
constexpr std::string_view kHirano = "Hirano (1980), -(0.4 + 0.1 C_b)";

class Estimating {
 public:
  explicit Estimating(const CompleteHull& hull) : h_(hull), form_(hull.form) {}

  CoefficientEstimates run() {
    inertia();
    hull_forces();
    if (h_.has_screw) {
      propeller();
      if (!h_.given.rudder || !h_.given.rudder->is_vectwin) rudder();
    }
    return std::move(result_);
  }

 private:
  double add(const char* name, std::vector<MethodValue> methods, std::string remark = "") {
    double sum = 0.0;
    for (const MethodValue& method : methods) sum += method.value;
    const double value = sum / static_cast<double>(methods.size());
    result_.all.push_back({name, value, std::move(methods), std::move(remark)});
    return value;
  }

  void check(const FormulaRange& range) {
    const auto outside = [&](const char* what, double value, double low, double high) {
      if (value >= low && value <= high) return;
      if (!told_.insert(std::string(range.source) + what).second) return;
      result_.warnings.push_back(fmt::format("{} is {:.3g}: outside of {:g} to {:g}, for which {} is made", what, value,
                                             low, high, range.source));
    };
    outside("C_b", form_.C_b, range.C_b_low, range.C_b_high);
    outside("L/B", form_.L_by_B, range.L_by_B_low, range.L_by_B_high);
    outside("B/d", form_.B_by_d, range.B_by_d_low, range.B_by_d_high);
  }

  void inertia() {
    for (const FormulaRange* range : {&kClarke, &kZhou}) check(*range);
    m_x_ = add("inertia.m_x",
               {{"5 % of m, Clarke, Gedling & Hine (1983)", m_x_by_clarke(form_)}, {kSoeding, m_x_by_soeding(form_)}});
    m_y_ = add("inertia.m_y", {{kZhou.source, m_y_by_zhou(form_)}, {kClarke.source, m_y_by_clarke(form_)}});
    const double I_zG = form_.m * 0.0625;
    add("inertia.I_z", {{kZhou.source, I_zG + J_z_by_zhou(form_)}, {kClarke.source, I_zG + J_z_by_clarke(form_)}},
        "with a radius of gyration of 0.25 L for I_zG");
  }

  void hull_forces() {
    for (const FormulaRange* range : {&kKijima, &kLee, &kYoshimura}) check(*range);
    const double U = h_.service_speed, q = 0.5 * h_.water.rho * h_.given.L_pp * h_.given.d * U * U;
    const double C_P = h_.holtrop.C_P();
    if (C_P < 0.55 || C_P > 0.85)
      result_.warnings.push_back(
          fmt::format("C_P is {:.3g}: outside of 0.55 to 0.85, for which Holtrop & Mennen (1982) is made", C_P));
    add("hull.resistance", {{kHoltrop, holtrop_resistance(h_.holtrop, U).total / q}},
        fmt::format("at {:.4g} m/s, Froude number {:.3f}", U, h_.Froude()));
    const LinearDerivatives a = linear_by_kijima(form_, m_x_), b = linear_by_clarke(form_),
                            c = linear_by_lee(form_, m_x_);
    const auto mean = [&](const char* name, double LinearDerivatives::*of) {
      add(name, {{kKijima.source, a.*of}, {kClarke.source, b.*of}, {kLee.source, c.*of}});
    };
    mean("hull.Y_v", &LinearDerivatives::Y_v);
    mean("hull.Y_r", &LinearDerivatives::Y_r);
    mean("hull.N_v", &LinearDerivatives::N_v);
    mean("hull.N_r", &LinearDerivatives::N_r);
    const FurtherDerivatives f = further_by_yoshimura(form_, m_y_);
    add("hull.X_vv", {{kYoshimura.source, f.X_vv}});
    add("hull.X_vr", {{kYoshimura.source, f.X_vr}});
    add("hull.X_rr", {{kYoshimura.source, f.X_rr}});
    add("hull.X_vvvv", {{kYoshimura.source, f.X_vvvv}});
    add("hull.Y_vvv", {{kYoshimura.source, f.Y_vvv}});
    add("hull.Y_vvr", {{kYoshimura.source, f.Y_vvr}, {kLee.source, Y_vvr_by_lee(form_)}});
    add("hull.Y_vrr", {{kYoshimura.source, f.Y_vrr}});
    add("hull.Y_rrr", {{kYoshimura.source, f.Y_rrr}});
    add("hull.N_vvv", {{kYoshimura.source, f.N_vvv}});
    add("hull.N_vvr", {{kYoshimura.source, f.N_vvr}});
    add("hull.N_vrr", {{kYoshimura.source, f.N_vrr}});
    add("hull.N_rrr", {{kYoshimura.source, f.N_rrr}});
  }

  void propeller() {
    const SeriesPropeller& s = h_.screw;
    const auto outside = [&](const char* what, double value, double low, double high) {
      if (value < low || value > high)
        result_.warnings.push_back(
            fmt::format("the propeller's {} is {:.3g}: outside of {:g} to {:g}, the B series", what, value, low, high));
    };
    outside("pitch ratio", s.pitch_ratio, 0.5, 1.4);
    outside("area ratio", s.area_ratio, 0.3, 1.05);
    outside("number of blades", s.blades, 2.0, 7.0);
    const QuadraticThrust fit = fit_quadratic(s);
    result_.K_T = fit.K_T;
    const double J = 0.5 * wageningen_J_0(s);
    add("propeller.K_T", {{"Wageningen B series, Oosterveld & van Oossanen (1975)", wageningen_K_T(s, J)}},
        fmt::format(
            "B{:.0f}-{:.0f}, P/D {:.3f}; the quadratic in J is within {:.4f} of the series; here K_T at J {:.2f}",
            s.blades, 100.0 * s.area_ratio, s.pitch_ratio, fit.largest_error, J));
    const double holtrop = std::clamp(wake_by_holtrop(h_), 0.0, 0.6);
    add("propeller.1-w_P", {{kYoshimura.source, 1.0 - w_P0_by_yoshimura(form_)}, {kHoltrop, 1.0 - holtrop}});
    add("propeller.1-t_P", {{kHoltrop, 1.0 - std::clamp(holtrop_thrust_deduction(h_.holtrop, h_.D_P), 0.0, 0.4)}});
    add("propeller.C_1", {{kStandard, 2.0}}, "that of KVLCC2");
    add("propeller.C_2_negative", {{kStandard, 1.1}}, "that of KVLCC2");
    add("propeller.C_2_positive", {{kStandard, 1.6}}, "that of KVLCC2");
  }

  void rudder() {
    const double w_P0 = 1.0 - result_["propeller.1-w_P"];
    add("rudder.1-t_R", {{kYoshimura.source, 1.0 - t_R_by_yoshimura()}, {kKijima.source, 1.0 - t_R_by_kijima(form_)}});
    add("rudder.gain", {{kFujii, f_alpha_by_fujii(h_.H_R * h_.H_R / h_.A_R)}});
    add("rudder.a_H",
        {{kYoshimura.source, a_H_by_yoshimura(form_)}, {kQuadvlieg, std::max(0.05, a_H_by_quadvlieg(form_))}});
    add("rudder.x_H", {{kYoshimura.source, x_H_by_yoshimura()}, {kHirano, x_H_by_hirano(form_)}});
    add("rudder.l_R", {{kYoshimura.source, -0.9}});
    const double epsilon = std::clamp(epsilon_by_yoshimura(w_P0), 0.7, 1.8);
    add("rudder.epsilon", {{kYoshimura.source, epsilon}}, "2.26 - 1.82 (1 - w_P0)");
    add("rudder.kappa", {{kYoshimura.source, 0.55 / epsilon}}, "0.55/epsilon");
    // A right-handed screw straightens the flow less where the stern swings to port; the ratio is that of tankers.
    constexpr double kSide = 1.15;
    const double gamma_R = gamma_R_by_yoshimura(form_);
    add("rudder.gamma_R_negative", {{kYoshimura.source, gamma_R / kSide}},
        "2.06 C_b B/L + 0.14, by 1.15: a right-handed screw's sides (ours)");
    add("rudder.gamma_R_positive", {{kYoshimura.source, gamma_R * kSide}},
        "2.06 C_b B/L + 0.14, times 1.15: a right-handed screw's sides (ours)");
  }

  const CompleteHull& h_;
  const HullForm& form_;
  double m_x_ = 0.0, m_y_ = 0.0;
  CoefficientEstimates result_;
  std::set<std::string> told_;
};

}  // namespace

std::string CoefficientEstimate::source() const {
  std::string text = methods.size() > 1 ? "mean of " : "";
  for (std::size_t i = 0; i < methods.size(); ++i) {
    text += fmt::format("{}{}", i > 0 ? "; " : "", methods[i].source);
    if (methods.size() > 1) text += fmt::format(" ({:.3g})", methods[i].value);
  }
  return remark.empty() ? text : text + ": " + remark;
}

const CoefficientEstimate* CoefficientEstimates::find(std::string_view name) const {
  const auto found = std::ranges::find_if(all, [&](const CoefficientEstimate& c) { return c.name == name; });
  return found == all.end() ? nullptr : &*found;
}

double CoefficientEstimates::operator[](std::string_view name) const {
  const CoefficientEstimate* found = find(name);
  if (found == nullptr) throw std::logic_error("no coefficient '" + std::string(name) + "'");
  return found->value;
}

CoefficientEstimates estimate_coefficients(const CompleteHull& hull) { return Estimating(hull).run(); }

}  // namespace leeway::estimate
