#include "gap/report/locate_json.hpp"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/units.hpp"
#include "gap/report/words.hpp"

namespace leeway::gap {
namespace {

using io::Json;

// By axis: the key's unit, and what turns SI into it.
constexpr std::array<const char*, 3> kAccelerationUnits{"mps2", "mps2", "degps2"};
constexpr std::array<double, 3> kPerSi{1.0, 1.0, 1.0 / kDegree};

Json numbers(const std::vector<double>& values, double factor = 1.0) {
  Json result = Json::array();
  for (const double value : values) result.push_back(number(value * factor));
  return result;
}

template <typename Items, typename Write>
Json array_of(const Items& items, const Write& write) {
  Json result = Json::array();
  for (const auto& item : items) result.push_back(write(item));
  return result;
}

std::string axis_name(int axis) { return kAxisNames.at(static_cast<std::size_t>(axis)); }

Json acceleration(const Vec3<double>& value) {
  Json result = Json::object();
  for (int a = 0; a < 3; ++a)
    result[fmt::format("{}_{}", axis_name(a), kAccelerationUnits[a])] = number(value(a) * kPerSi[a]);
  return result;
}

// One parameter: numbers; several: objects by the parameter's name.
Json one_or_by_name(const std::vector<Estimate>& parameters, double Estimate::*member) {
  if (parameters.empty()) return nullptr;
  if (parameters.size() == 1) return number(parameters.front().*member);
  Json result = Json::object();
  for (const Estimate& parameter : parameters) result[parameter.name] = number(parameter.*member);
  return result;
}

Json to_json(const Fault& fault) {
  Json parameters = Json::object();
  for (const Estimate& p : fault.parameters)
    parameters[p.name] = {{"estimate", number(p.value)}, {"sd", number(p.sd)}, {"unit", unit_of(p.name)}};
  return {{"name", fault.name},
          {"estimate", one_or_by_name(fault.parameters, &Estimate::value)},
          {"sd", one_or_by_name(fault.parameters, &Estimate::sd)},
          {"heldout_gain", number(fault.heldout_gain)},
          {"heldout_gain_sd", number(fault.heldout_gain_sd)},
          {"p_value", number(fault.p_value)},
          {"parameters", parameters},
          {"sentence", fault.sentence}};
}

Json to_json(const Audit& audit) {
  const auto fault = [](const Fault& f) { return to_json(f); };
  Json channels = Json::object();
  for (const ChannelQuality& c : audit.channels) {
    const double unit = column_unit(c.channel);
    const std::string name = column_name(c.channel);
    channels[name] = {{"noise_sd", number(c.noise_sd / unit)},
                      {"correlation_s", number(c.correlation_s)},
                      {"filter_s", number(c.filter_s)},
                      {"missing_share", number(c.missing_share)},
                      {"frozen_share", number(c.frozen_share)},
                      {"resolution", number(c.resolution / unit)},
                      {"unit", unit_of(name)}};
  }
  const char* verdict = audit.verdict() == Audit::Verdict::consistent ? "consistent"
                        : audit.verdict() == Audit::Verdict::faulty   ? "faulty"
                                                                      : "unchecked";
  return {{"verdict", verdict},
          {"faults", array_of(audit.faults, fault)},
          {"hypotheses", array_of(audit.hypotheses, fault)},
          {"channels", channels},
          {"log_through_water", audit.log_through_water ? Json(*audit.log_through_water) : Json(nullptr)},
          {"notices", audit.notices}};
}

Json to_json(const Conventions& conventions) {
  const auto reading = [](const Reading& r) {
    return Json{{"channel", r.channel},
                {"name", r.name},
                {"recording", r.recording.empty() ? Json(nullptr) : Json(r.recording)},
                {"log_odds", number(r.log_odds)},
                {"error_ratio", number(r.error_ratio)},
                {"sentence", r.sentence}};
  };
  return {{"contradicted", array_of(conventions.contradicted, reading)},
          {"tested", array_of(conventions.tested, reading)},
          {"unchecked", conventions.unchecked}};
}

Json to_json(const Training& training, int axis) {
  const auto a = static_cast<std::size_t>(axis);
  Json outside = Json::object();
  for (const OutsideInput& input : training.outside) outside[input.name] = number(input.share);
  return {{"outside_share", number(training.outside_share)},
          {"outside", outside},
          {fmt::format("members_sd_{}", kAccelerationUnits.at(a)), number(training.spread * kPerSi.at(a))},
          {"mismatch_by_members_sd", number(training.mismatch_by_spread)}};
}

Json to_json(const EnsembleUsed& ensemble) {
  return {{"name", ensemble.name},
          {"members", ensemble.members},
          {"time_step_s", number(ensemble.time_step_s)},
          {"base", ensemble.base.empty() ? Json(nullptr) : Json(ensemble.base)},
          {"outside_share", number(ensemble.outside_share)},
          {"members_sd", acceleration(ensemble.spread)}};
}

Json to_json(const Located& located, double L_pp) {
  Json dof = Json::object();
  for (int a = 0; a < 3; ++a) dof[axis_name(a)] = number(located.share(a));
  Json line_of_action = nullptr;
  if (located.line_of_action) {
    const auto& [name, value, sd] = *located.line_of_action;
    line_of_action = {{"x_F_over_L_pp", number(value)},
                      {"x_F_over_L_pp_sd", number(sd)},
                      {"x_F_m", L_pp > 0.0 ? number(value * L_pp) : Json(nullptr)},
                      {"x_F_sd_m", L_pp > 0.0 ? number(sd * L_pp) : Json(nullptr)}};
  }
  const auto interval = [](const Interval& i) {
    return Json{{"file", i.file},
                {"recording", i.recording},
                {"t_start_s", number(i.t_start_s)},
                {"t_end_s", number(i.t_end_s)},
                {"dof", axis_name(i.axis)},
                {"p_value", number(i.p_value)},
                {"mean_acceleration", acceleration(i.acceleration)},
                {"cause", i.is_untrained() ? Json(kUntrained) : Json(nullptr)},
                {"training", i.training ? to_json(*i.training, i.axis) : Json(nullptr)}};
  };
  const auto regime = [](const Regime& r) {
    const auto a = static_cast<std::size_t>(r.axis);
    const std::string unit = kAccelerationUnits.at(a);
    return Json{{"variable", r.variable},
                {"relation", r.relation},
                {"sentence", r.sentence},
                {"dof", axis_name(r.axis)},
                {"p_value", number(r.p_value)},
                {"q_value", number(r.q_value)},
                {"share", number(r.share)},
                {"x_label", r.x_label},
                {"x", numbers(r.x)},
                {"mean_" + unit, numbers(r.mean, kPerSi[a])},
                {"mean_sd_" + unit, numbers(r.mean_sd, kPerSi[a])}};
  };
  return {{"dof", dof},
          {"line_of_action", line_of_action},
          {"intervals", array_of(located.intervals, interval)},
          {"regime", array_of(located.regimes, regime)},
          {"frames", array_of(located.frames,
                              [](const Frame& f) {
                                return Json{{"name", f.name},
                                            {"meaning", frame_meaning(f.name)},
                                            {"log_evidence", number(f.log_evidence)},
                                            {"share", number(f.share)}};
                              })},
          {"modules", array_of(located.modules, [](const WalkingGain& m) {
             return Json{{"name", m.module},
                         {"log_likelihood_gain", number(m.log_likelihood_gain)},
                         {"gain_sd", number(m.gain_sd)},
                         {"sigma_w_factor", number(m.sigma_w_factor)}};
           })}};
}

Json sigma_w(const NullFit& fit) {
  Json result = Json::object();
  for (int a = 0; a < 3; ++a) {
    const std::string axis = axis_name(a), unit = kAccelerationUnits[a];
    result[fmt::format("{}_{}", axis, unit)] = number(fit.sigma_w(a) * kPerSi[a]);
    result[fmt::format("{}_sd_{}", axis, unit)] = number(fit.sigma_w_sd(a) * kPerSi[a]);
    result[fmt::format("{}_typical_{}", axis, unit)] = number(fit.typical(a) * kPerSi[a]);
    result[fmt::format("{}_share_of_typical", axis)] = number(fit.sigma_w(a) / fit.typical(a));
  }
  result["tau_s"] = number(fit.tau_s);
  result["coefficient_scale"] = number(fit.coefficient_scale);
  result["receiver"] = fit.receiver ? Json{{"sd_mps", fit.receiver->sd_mps}, {"tau_s", fit.receiver->tau_s}} : Json();
  return result;
}

Json to_json(const NullFit& fit) {
  Json noise = Json::object();
  for (const Estimate& e : fit.noise) noise[e.name] = {{"estimate", number(e.value)}, {"sd", number(e.sd)}};
  return {{"converged", fit.converged},
          {"iterations", fit.iterations},
          {"gradient", number(fit.gradient)},
          {"noise_gradient", number(fit.noise_gradient)},
          {"log_likelihood", number(fit.log_likelihood)},
          {"log_likelihood_per_sample", number(fit.log_likelihood_per_sample)},
          {"samples", fit.samples},
          {"outliers", fit.outliers},
          {"is_noise_free", fit.is_noise_free},
          {"step_s", number(fit.step_s)},
          {"distance", number(fit.distance)},
          {"parameters", to_json(fit.parameters)},
          {"actuator_lag_samples", number(fit.actuator_lag.value)},
          {"actuator_lag_sd_samples", number(fit.actuator_lag.sd)},
          {"noise", noise}};
}

Json to_json(const Detection& detection) {
  Json imitated = Json::array();
  for (Eigen::Index i = 0; i < detection.imitated.rows(); ++i) {
    imitated.push_back(Json::array());
    for (Eigen::Index j = 0; j < detection.imitated.cols(); ++j)
      imitated.back().push_back(std::round(1e3 * detection.imitated(i, j)) / 1e3);
  }
  return {{"p_value", number(detection.p_value)},
          {"whiteness_p_value", number(detection.whiteness_p_value)},
          {"false_alarm", number(detection.false_alarm)},
          {"heldout_gain", number(detection.heldout_gain)},
          {"heldout_gain_sd", number(detection.heldout_gain_sd)},
          {"reason", detection.reason},
          {"untested", detection.untested},
          {"imitation", {{"effects", detection.compared}, {"shares", imitated}}},
          {"effects", array_of(detection.effects, [](const Screened& e) {
             return Json{{"name", e.name},
                         {"p_value", number(e.p_value)},
                         {"log_bayes_factor", number(e.log_bayes_factor)},
                         {"heldout_gain", number(e.heldout_gain)},
                         {"heldout_gain_sd", number(e.heldout_gain_sd)}};
           })}};
}

}  // namespace

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json to_json(const std::vector<ParameterShift>& shifts) {
  Json result = Json::object();
  for (const ParameterShift& p : shifts) {
    result[p.name] = {{"factor", number(p.factor)},
                      {"factor_sd", number(p.factor_sd)},
                      {"prior_log_sd", p.difference ? Json(nullptr) : number(p.prior_log_sd)},
                      {"shift_in_prior_sd", number(p.shift_sd)}};
    if (p.difference)
      result[p.name].update({{"shift", number(p.difference->estimate)},
                             {"shift_sd", number(p.difference->sd)},
                             {"prior_sd", number(p.difference->prior_sd)}});
  }
  return result;
}

Json to_json(const Findings& findings) {
  const auto recording = [](const Residual& r) {
    return Json{{"recording", r.recording},
                {"file", r.file},
                {"points", r.t_s.size()},
                {"t_start_s", r.t_s.empty() ? Json(nullptr) : number(r.t_s.front())},
                {"t_end_s", r.t_s.empty() ? Json(nullptr) : number(r.t_s.back())},
                {"has_position", r.has_position}};
  };
  return {{"ship", findings.ship},
          {"ensemble", findings.ensemble ? to_json(*findings.ensemble) : Json(nullptr)},
          {"verdict", word(findings.verdict)},
          {"p_value", number(findings.detection.p_value)},
          {"sentence", headline(findings)},
          {"located", to_json(findings.located, findings.L_pp)},
          {"audit", to_json(findings.audit)},
          {"sigma_w", sigma_w(findings.fit)},
          {"conventions", to_json(findings.conventions)},
          {"faults_taken_out", findings.corrected},
          {"detection", to_json(findings.detection)},
          {"null_fit", to_json(findings.fit)},
          {"recordings", array_of(findings.residuals, recording)},
          {"grossly_inconsistent", findings.grossly_inconsistent},
          {"L_pp_m", number(findings.L_pp)},
          {"notices", findings.notices}};
}

}  // namespace leeway::gap
