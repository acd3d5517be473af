#include "estimate/coefficient_estimates.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

namespace leeway::estimate {
namespace {

class Estimating {
 public:
  explicit Estimating(const CompleteHull& hull) : h_(hull), form_(hull.form) {}

  CoefficientEstimates run() {
    result_.warnings = h_.warnings;
    check_state();
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
    for (const MethodValue& method : methods) {
      check(*method.formula);
      sum += method.value;
    }
    const double value = sum / static_cast<double>(methods.size());
    result_.all.push_back({name, value, std::move(methods), std::move(remark)});
    return value;
  }

  double parameter(std::string_view name) const {
    const std::pair<std::string_view, double> all[] = {{"C_b", form_.C_b},
                                                       {"L/B", form_.L_by_B},
                                                       {"B/d", form_.B_by_d},
                                                       {"C_P", h_.holtrop.C_P()},
                                                       {"Fr", h_.Froude()},
                                                       {"aspect ratio", h_.H_R * h_.H_R / h_.A_R},
                                                       {"P/D", h_.screw.pitch_ratio},
                                                       {"A_E/A_0", h_.screw.area_ratio},
                                                       {"blades", h_.screw.blades}};
    return std::ranges::find(all, name, [](const auto& p) { return p.first; })->second;
  }

  void check(const FormulaRange& formula) {
    for (const auto& [name, low, high] : formula.parameters) {
      const double value = parameter(name);
      if (value >= low && value <= high) continue;
      if (!told_.insert(std::string(formula.source) + std::string(name)).second) continue;
      result_.warnings.push_back(fmt::format("{} is {:.3g}: outside of {:g} to {:g}, for which {} is made", name, value,
                                             low, high, formula.source));
    }
  }

  // What no formula asks for and all of them take for granted: an even keel, a service speed, a design draft.
  void check_state() {
    constexpr double kLevelTrim = 0.05, kSlowFroude = 0.08, kLeastReynolds = 1e6, kMostBreadthByDesignDraft = 4.0;
    const HullParticulars& p = h_.given;
    std::vector<std::string>& warnings = result_.warnings;
    const double trim = p.d_aft - p.d_fore;
    if (std::abs(trim) > kLevelTrim * p.d)
      warnings.push_back(
          fmt::format("the trim by the {}, {:.3g} m, is {:.0f} % of the draft: hull derivatives and interaction are "
                      "those of an even "
                      "keel (up to {:.0f} %)",
                      trim > 0.0 ? "stern" : "bow", std::abs(trim), 100.0 * std::abs(trim) / p.d, 100.0 * kLevelTrim));
    if (h_.Froude() < kSlowFroude)
      warnings.push_back(fmt::format(
          "the service speed of {:.4g} m/s is a Froude number of {:.3g}; usual: {:g} to 0.45: resistance, wake and "
          "revolutions are taken at it, and hold for it",
          h_.service_speed, h_.Froude(), kSlowFroude));
    if (const double Re = h_.service_speed * p.L_pp / h_.water.nu; Re < kLeastReynolds)
      warnings.push_back(
          fmt::format("the Reynolds number at service speed is {:.3g}; the friction line of ITTC 1957 is for turbulent "
                      "flow, from {:g} on",
                      Re, kLeastReynolds));
    const bool is_sized =
        (!h_.has_screw || (p.propeller && p.propeller->diameter)) && (!h_.has_screw || (p.rudder && p.rudder->area));
    if (!is_sized && form_.B_by_d > kMostBreadthByDesignDraft)
      warnings.push_back(fmt::format(
          "B/d is {:.3g}; usual at the design draft: 2 to {:g}. Propeller and rudder are sized by statistics of the "
          "design draft: at a ballast draft state propeller/diameter_m and rudder/area_m2",
          form_.B_by_d, kMostBreadthByDesignDraft));
  }

  // A formula's value within what makes sense; where it is held, the remark and a warning say so.
  double limited(const std::string& what, double value, double low, double high, const FormulaRange& formula,
                 std::string& remark) {
    const double held = std::clamp(value, low, high);
    if (held == value) return value;
    remark += fmt::format("{}{} limited to {:g} from {:.3g}", remark.empty() ? "" : "; ", what, held, value);
    result_.warnings.push_back(
        fmt::format("{} is {:.3g} by {}: limited to {:g} to {:g}", what, value, formula.source, low, high));
    return held;
  }

  void inertia() {
    m_x_ = add("inertia.m_x", {{&kClarkeSurge, m_x_by_clarke(form_)}, {&kSoeding, m_x_by_soeding(form_)}});
    m_y_ = add("inertia.m_y", {{&kZhou, m_y_by_zhou(form_)}, {&kClarke, m_y_by_clarke(form_)}});
    const double I_zG = form_.m * 0.0625;
    add("inertia.I_z", {{&kZhou, I_zG + J_z_by_zhou(form_)}, {&kClarke, I_zG + J_z_by_clarke(form_)}},
        "with a radius of gyration of 0.25 L for I_zG");
  }

  void hull_forces() {
    const double U = h_.service_speed, q = 0.5 * h_.water.rho * h_.given.L_pp * h_.given.d * U * U;
    std::string limits;
    for (const std::string& limit : holtrop_limits(h_.holtrop)) {
      result_.warnings.push_back(fmt::format("{}: {} is not made for such a hull", limit, kHoltrop.source));
      limits += "; " + limit;
    }
    add("hull.resistance", {{&kHoltrop, holtrop_resistance(h_.holtrop, U).total / q}},
        fmt::format("at {:.4g} m/s, Froude number {:.3f}{}", U, h_.Froude(), limits));
    const LinearDerivatives a = linear_by_kijima(form_, m_x_), b = linear_by_clarke(form_),
                            c = linear_by_lee(form_, m_x_);
    const auto mean = [&](const char* name, double LinearDerivatives::*of) {
      add(name, {{&kKijima, a.*of}, {&kClarke, b.*of}, {&kLee, c.*of}});
    };
    mean("hull.Y_v", &LinearDerivatives::Y_v);
    mean("hull.Y_r", &LinearDerivatives::Y_r);
    mean("hull.N_v", &LinearDerivatives::N_v);
    mean("hull.N_r", &LinearDerivatives::N_r);
    const FurtherDerivatives f = further_by_yoshimura(form_, m_y_);
    add("hull.X_vv", {{&kYoshimura, f.X_vv}});
    add("hull.X_vr", {{&kYoshimura, f.X_vr}});
    add("hull.X_rr", {{&kYoshimura, f.X_rr}});
    add("hull.X_vvvv", {{&kYoshimura, f.X_vvvv}});
    add("hull.Y_vvv", {{&kYoshimura, f.Y_vvv}});
    add("hull.Y_vvr", {{&kYoshimura, f.Y_vvr}, {&kLee, Y_vvr_by_lee(form_)}});
    add("hull.Y_vrr", {{&kYoshimura, f.Y_vrr}});
    add("hull.Y_rrr", {{&kYoshimura, f.Y_rrr}});
    add("hull.N_vvv", {{&kYoshimura, f.N_vvv}});
    add("hull.N_vvr", {{&kYoshimura, f.N_vvr}});
    add("hull.N_vrr", {{&kYoshimura, f.N_vrr}});
    add("hull.N_rrr", {{&kYoshimura, f.N_rrr}});
  }

  void propeller() {
    const SeriesPropeller& s = h_.screw;
    const QuadraticThrust fit = fit_quadratic(s);
    result_.K_T = fit.K_T;
    const double J = 0.5 * wageningen_J_0(s);
    add("propeller.K_T", {{&kWageningen, wageningen_K_T(s, J)}},
        fmt::format(
            "B{:.0f}-{:.0f}, P/D {:.3f}; the quadratic in J is within {:.4f} of the series; here K_T at J {:.2f}",
            s.blades, 100.0 * s.area_ratio, s.pitch_ratio, fit.largest_error, J));
    std::string wake, deduction;
    const double w_P = limited("w_P", wake_by_holtrop(h_), 0.0, 0.6, kHoltrop, wake);
    const double t_P = limited("t_P", holtrop_thrust_deduction(h_.holtrop, h_.D_P), 0.0, 0.4, kHoltrop, deduction);
    add("propeller.1-w_P", {{&kYoshimura, 1.0 - w_P0_by_yoshimura(form_)}, {&kHoltrop, 1.0 - w_P}}, wake);
    add("propeller.1-t_P", {{&kHoltrop, 1.0 - t_P}}, deduction);
    add("propeller.C_1", {{&kStandard, 2.0}}, "that of KVLCC2");
    add("propeller.C_2_negative", {{&kStandard, 1.1}}, "that of KVLCC2");
    add("propeller.C_2_positive", {{&kStandard, 1.6}}, "that of KVLCC2");
  }

  void rudder() {
    const double w_P0 = 1.0 - result_["propeller.1-w_P"];
    add("rudder.1-t_R", {{&kYoshimura, 1.0 - t_R_by_yoshimura()}, {&kKijima, 1.0 - t_R_by_kijima(form_)}});
    add("rudder.gain", {{&kFujii, f_alpha_by_fujii(h_.H_R * h_.H_R / h_.A_R)}});
    std::string a_H_limit, remark = "2.26 - 1.82 (1 - w_P0)";
    const double a_H = limited("a_H", a_H_by_quadvlieg(form_), 0.05, 1.0, kQuadvlieg, a_H_limit);
    add("rudder.a_H", {{&kYoshimura, a_H_by_yoshimura(form_)}, {&kQuadvlieg, a_H}}, a_H_limit);
    add("rudder.x_H", {{&kYoshimura, x_H_by_yoshimura()}, {&kHirano, x_H_by_hirano(form_)}});
    add("rudder.l_R", {{&kYoshimura, -0.9}});
    const double epsilon = limited("epsilon", epsilon_by_yoshimura(w_P0), 0.7, 1.8, kYoshimura, remark);
    add("rudder.epsilon", {{&kYoshimura, epsilon}}, remark);
    add("rudder.kappa", {{&kYoshimura, 0.55 / epsilon}}, "0.55/epsilon");
    // A right-handed screw straightens the flow less where the stern swings to port; the ratio is that of tankers.
    constexpr double kSide = 1.15;
    const double gamma_R = gamma_R_by_yoshimura(form_);
    add("rudder.gamma_R_negative", {{&kYoshimura, gamma_R / kSide}},
        "2.06 C_b B/L + 0.14, by 1.15: a right-handed screw's sides (ours)");
    add("rudder.gamma_R_positive", {{&kYoshimura, gamma_R * kSide}},
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
    text += fmt::format("{}{}", i > 0 ? "; " : "", methods[i].formula->cited());
    if (methods.size() > 1) text += fmt::format(" ({:.3g})", methods[i].value);
  }
  return remark.empty() ? text : text + ": " + remark;
}

bool CoefficientEstimate::differs_in_sign() const {
  const auto is_negative = [](const MethodValue& m) { return m.value < 0.0; };
  return std::ranges::any_of(methods, is_negative) && !std::ranges::all_of(methods, is_negative);
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
