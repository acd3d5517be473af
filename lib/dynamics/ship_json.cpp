#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/errors.hpp"
#include "core/units.hpp"
#include "dynamics/ship_report.hpp"
#include "dynamics/straight_run.hpp"
#include "forces/inertia.hpp"

/// What `mmg-sim show --json` says.
namespace leeway {
namespace {

using io::Json;

Json finite_or_null(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json particulars_of(const Ship& ship) {
  const Particulars& p = ship.particulars;
  const Inertia<double> inertia(ship.inertia, p);
  return {{"L_pp_m", p.L_pp},
          {"B_m", p.B},
          {"d_m", p.d},
          {"rho_kgpm3", p.rho},
          {"C_b", ship.block_coefficient()},
          {"m_kg", inertia.m},
          {"m_x_kg", inertia.m_x},
          {"m_y_kg", inertia.m_y},
          {"x_G_m", inertia.x_G},
          {"I_zG_plus_J_z_kgm2", inertia.I_z}};
}

Json actuators_of(const Ship& ship) {
  Json result = Json::array();
  for (const Actuator& a : ship.actuators) {
    const double k = a.is_angle() ? 1.0 / kDegree : 1.0;
    const std::string unit = a.is_angle() ? "_deg" : "_rps";
    result.push_back({{"channel", info(a.channel).name},
                      {"min" + unit, finite_or_null(k * a.min)},
                      {"max" + unit, finite_or_null(k * a.max)},
                      {a.is_angle() ? "rate_degps" : "rate_rpsps", k * a.rate},
                      {"time_constant_s", a.time_constant_s},
                      {"initial" + unit, k * a.initial}});
    if (a.n_at_pitch_current_1 > 0.0) result.back()["n_rps_at_pitch_current_1"] = a.n_at_pitch_current_1;
  }
  return result;
}

Json coefficients_of(const Ship& ship) {
  Json result = Json::array();
  for (const ReportedCoefficient& c : reported_coefficients(ship))
    result.push_back({{"name", c.name},
                      {"value", c.value ? Json(*c.value) : Json(nullptr)},
                      {"interval95", {c.low, c.high}},
                      {"is_stated", c.is_stated},
                      {"is_absolute", c.is_absolute},
                      {"source", c.source}});
  return result;
}

Json effects_of(const Ship& ship) {
  Json result = Json::array();
  for (const EffectEntry& effect : ship.effects) {
    result.push_back({{"type", effect.type}});
    for (const auto& [name, value] : effect.parameters) result.back()[name] = value ? Json(*value) : Json(nullptr);
  }
  return result;
}

Json network_of(const Ship& ship) {
  if (!ship.residual_network) return nullptr;
  Json inputs = Json::array(), layers = Json::array();
  for (const ResidualNetwork::Input& input : ship.residual_network->inputs)
    inputs.push_back({{"name", input.name}, {"low", input.low}, {"high", input.high}});
  for (const ResidualNetwork::Layer& layer : ship.residual_network->layers)
    layers.push_back({{"outputs", layer.weights.rows()}, {"inputs", layer.weights.cols()}});
  return {{"source", ship.residual_network->source}, {"inputs", inputs}, {"layers", layers}};
}

Json joint_uncertainty_of(const Ship& ship) {
  if (!ship.coefficient_covariance) return nullptr;
  const Ship::JointUncertainty& joint = *ship.coefficient_covariance;
  Json coefficients = Json::array(), correlations = Json::array();
  for (std::size_t i = 0; i < joint.names.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    coefficients.push_back({{"name", joint.names[i]},
                            {"sd", std::sqrt(joint.matrix(k, k))},
                            {"is_absolute", ship.is_absolute(joint.names[i])}});
  }
  for (const Correlation& c : strongest_correlations(joint))
    correlations.push_back({{"names", {c.a, c.b}}, {"correlation", c.value}});
  return {{"coefficients", coefficients}, {"strongest_correlations", correlations}};
}

// null where there is no such run.
template <typename Compute>
Json run_of(const Compute& compute) {
  try {
    const StraightRun run = compute();
    return {{"u_mps", run.u},        {"n_rps", run.n},   {"J", run.J},       {"one_minus_w_P", run.one_minus_w_P},
            {"K_T", run.K_T},        {"X_P_N", run.X_P}, {"X_H_N", run.X_H}, {"X_R_N", run.X_R + 0.0},
            {"X_A_N", run.X_A + 0.0}};
  } catch (const NumericalError&) {
    return nullptr;
  }
}

}  // namespace

Json ship_json(const Ship& ship) {
  Json modules = Json::array(), factors = Json::object(), shifts = Json::object();
  for (const PartSource& s : ship.sources)
    modules.push_back({{"part", s.part}, {"type", s.type}, {"source", s.source}});
  for (const CoefficientFactor& by : ship.coefficient_factors) {
    if (by.factor != 1.0 || by.shift == 0.0) factors[by.name] = by.factor;
    if (by.shift != 0.0) shifts[by.name] = by.shift;
  }
  const double n = ship.propulsion().front().initial, u0 = ship.u0_mps;
  return {{"name", ship.name},
          {"description", ship.description},
          {"scale", ship.scale},
          {"u0_mps", u0},
          {"Fr", u0 / std::sqrt(kGravity_mps2 * ship.particulars.L_pp)},
          {"particulars", particulars_of(ship)},
          {"actuators", actuators_of(ship)},
          {"modules", modules},
          {"coefficients", coefficients_of(ship)},
          {"coefficient_factors", factors},
          {"coefficient_shifts", shifts},
          {"coefficient_covariance", joint_uncertainty_of(ship)},
          {"residual_network", network_of(ship)},
          {"effects", effects_of(ship)},
          {"straight_run",
           {{"at_initial_revolutions", run_of([&] { return straight_run(ship, steady_speed(ship, n), n); })},
            {"self_propulsion_at_u0", run_of([&] { return straight_run(ship, u0, self_propulsion_n(ship, u0)); })}}}};
}

}  // namespace leeway
