#include "estimate/measured_hulls.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/distributions.hpp"
#include "core/units.hpp"
#include "estimate/ship_estimate.hpp"
#include "io/files.hpp"

namespace leeway::estimate {
namespace {

// Y_v, N_v, Y_r, N_r of the rudder amidships in the race at self-propulsion, of 0.5 rho L d U^2.
LinearDerivatives share_of_rudder(const CompleteHull& h, const CoefficientEstimates& e) {
  const double one_minus_w = e["propeller.1-w_P"], epsilon = e["rudder.epsilon"], kappa = e["rudder.kappa"];
  const double U = h.service_speed, D = h.D_P;
  const double T = e["hull.resistance"] * 0.5 * h.given.L_pp * h.given.d * U * U / e["propeller.1-t_P"];  // by rho
  const double u_P = one_minus_w * U, race = std::sqrt(u_P * u_P + 8.0 * T / (kPi * D * D)) - u_P;
  const double inside = epsilon * (u_P + kappa * race) / U, outside = epsilon * u_P / U;
  const double eta = std::min(1.0, D / h.H_R);
  const double u_R = std::sqrt(eta * inside * inside + (1.0 - eta) * outside * outside);
  const double gamma_R = 0.5 * (e["rudder.gamma_R_negative"] + e["rudder.gamma_R_positive"]);
  const double side = h.A_R / (h.given.L_pp * h.given.d) * e["rudder.gain"] * u_R * gamma_R, l_R = e["rudder.l_R"];
  const double a_H = e["rudder.a_H"], arm = h.x_R / h.given.L_pp + a_H * e["rudder.x_H"];
  // v_R = -gamma_R (v + l_R r); F_N = -side-force of the angle v_R/u_R.
  return {-(1.0 + a_H) * side, -(1.0 + a_H) * side * l_R, -arm * side, -arm * side * l_R};
}

double K_T_at(const std::array<double, 3>& K_T, double J) { return K_T[0] + K_T[1] * J + K_T[2] * J * J; }

}  // namespace

MeasuredHull read_measured_hull(const std::string& path) {
  const io::Json text = io::read_json(path);
  io::JsonObject json(text, path);
  MeasuredHull result;
  result.name = json.text("name");
  result.description = json.text_or("description", "");
  result.source = json.text("source");
  io::JsonObject particulars = json.object("particulars");
  result.hull = fill(read_particulars(particulars));
  const CoefficientEstimates estimates = estimate_coefficients(result.hull);
  const io::JsonObject measured = json.object("measured");
  for (const std::string& name : measured.keys()) {
    if (name == "propeller.K_T") {
      const double J = 0.5 * wageningen_J_0(result.hull.screw);
      result.values.push_back({name, K_T_at(measured.array<3>(name), J), estimates[name]});
      continue;
    }
    const CoefficientEstimate* found = estimates.find(name);
    if (found == nullptr) measured.fail(name, "is no coefficient that is estimated");
    result.values.push_back({name, measured.number(name), found->value});
  }
  if (const auto whole = json.object_if("with_rudder")) {
    const LinearDerivatives rudder = share_of_rudder(result.hull, estimates);
    const std::pair<const char*, double> shares[] = {
        {"hull.Y_v", rudder.Y_v}, {"hull.Y_r", rudder.Y_r}, {"hull.N_v", rudder.N_v}, {"hull.N_r", rudder.N_r}};
    for (const auto& [name, share] : shares)
      if (whole->has(name)) result.values.push_back({name, whole->number(name) - share, estimates[name]});
    whole->check_all_known();
  }
  if (const auto turning = json.object_if("tactical_diameter_over_L")) {
    turning->text("source");
    const double diameter = turning->number("value", io::kPositive);
    turning->check_all_known();
    const Ship ship = estimate_unconditioned(result.hull.given, fit_widths({})).ship;
    result.values.push_back({std::string(kTacticalDiameter), diameter, tactical_diameter(ship).value_or(0.0)});
  }
  json.check_all_known();
  return result;
}

std::vector<MeasuredHull> measured_hulls() {
  std::vector<MeasuredHull> hulls;
  for (const std::string& name : io::config_names("hulls"))
    hulls.push_back(read_measured_hull(io::find_config("hulls", name)));
  return hulls;
}

// Judgment (ours): what the methods differ by, or about the modules' defaults where there is one method.
const std::vector<ErrorKind>& error_kinds() {
  static const std::vector<ErrorKind> kinds{{"inertia.m_x", false, 0.40},
                                            {"inertia.m_y", false, 0.15},
                                            {"inertia.I_z", false, 0.12},
                                            {"hull.resistance", false, 0.15},
                                            {"hull.Y_v", false, 0.15},
                                            {"hull.Y_r", true, 0.03},
                                            {"hull.N_v", false, 0.12},
                                            {"hull.N_r", false, 0.12},
                                            {"hull.X_vv", true, 0.03},
                                            {"hull.X_vr", true, 0.05},
                                            {"hull.X_rr", true, 0.015},
                                            {"hull.X_vvvv", true, 0.40},
                                            {"hull.Y_vvv", false, 0.25},
                                            {"hull.Y_vvr", true, 0.50},
                                            {"hull.Y_vrr", false, 0.20},
                                            {"hull.Y_rrr", true, 0.05},
                                            {"hull.N_vvv", true, 0.12},
                                            {"hull.N_vvr", false, 0.30},
                                            {"hull.N_vrr", true, 0.06},
                                            {"hull.N_rrr", false, 0.30},
                                            {"propeller.K_T", false, 0.06},
                                            {"propeller.1-w_P", false, 0.10},
                                            {"propeller.1-t_P", false, 0.05},
                                            {"propeller.C_1", false, 0.30},
                                            {"propeller.C_2_negative", false, 0.15},
                                            {"propeller.C_2_positive", false, 0.15},
                                            {"rudder.1-t_R", false, 0.12},
                                            {"rudder.gain", false, 0.08},
                                            {"rudder.a_H", false, 0.30},
                                            {"rudder.x_H", false, 0.10},
                                            {"rudder.l_R", false, 0.20},
                                            {"rudder.epsilon", false, 0.12},
                                            {"rudder.kappa", false, 0.15},
                                            {"rudder.gamma_R_negative", false, 0.20},
                                            {"rudder.gamma_R_positive", false, 0.20},
                                            {kTacticalDiameter, false, 0.12}};
  return kinds;
}

const ErrorKind* find_error_kind(std::string_view name) {
  const auto found = std::ranges::find_if(error_kinds(), [&](const ErrorKind& kind) { return kind.name == name; });
  return found == error_kinds().end() ? nullptr : &*found;
}

double error_of(const ErrorKind& kind, const MeasuredHull::Value& value) {
  if (kind.is_absolute) return value.measured - value.estimated;
  return std::log(value.measured / value.estimated);
}

namespace {

// What 95 % of Student's t lie within.
double t_quantile(double dof) {
  double low = 1.0, high = 100.0;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.5 * (low + high);
    (t_survival_two_sided(t, dof) > 0.05 ? low : high) = t;
  }
  return 0.5 * (low + high);
}

}  // namespace

std::vector<Width> fit_widths(const std::vector<MeasuredHull>& hulls, const std::vector<std::string>& without) {
  constexpr double kNormal95 = 1.959963985;
  std::vector<Width> widths;
  for (const ErrorKind& kind : error_kinds()) {
    double sum = kPriorHulls * kind.prior_sd * kind.prior_sd;
    int n = 0;
    for (const MeasuredHull& hull : hulls) {
      if (std::ranges::find(without, hull.name) != without.end()) continue;
      for (const MeasuredHull::Value& value : hull.values) {
        if (value.name != kind.name) continue;
        const double e = error_of(kind, value);
        if (!std::isfinite(e)) continue;
        sum += e * e;
        ++n;
      }
    }
    const double dof = kPriorHulls + n;
    widths.push_back({std::string(kind.name), std::sqrt(sum / dof) * t_quantile(dof) / kNormal95, n});
  }
  return widths;
}

Spread uncertainty_of(const CoefficientEstimate& estimate, const ErrorKind& kind, const std::vector<Width>& widths) {
  const auto width = std::ranges::find_if(widths, [&](const Width& w) { return w.name == kind.name; });
  const bool is_absolute = kind.is_absolute || estimate.differs_in_sign();
  double sum = 0.0;
  for (const MethodValue& method : estimate.methods) {
    const double e = is_absolute ? method.value - estimate.value : std::log(method.value / estimate.value);
    sum += e * e;
  }
  const double n = static_cast<double>(estimate.methods.size()), differ = n > 1.0 ? std::sqrt(sum / (n - 1.0)) : 0.0;
  const double own = is_absolute && !kind.is_absolute ? width->sd * std::abs(estimate.value) : width->sd;
  return {std::max(own, differ), is_absolute};
}

}  // namespace leeway::estimate
