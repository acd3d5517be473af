#include "gap/report/explain_json.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "gap/report/locate_json.hpp"
#include "gap/report/words.hpp"
#include "gap/result/inclusion.hpp"
#include "gap/show/next_maneuver.hpp"
#include "ship/joint_uncertainty.hpp"

namespace leeway::gap {
namespace {

using io::Json;

Json to_json(const Score& score) {
  return {{"points", score.points},
          {"rmse_u_mps", number(score.rmse_u_mps)},
          {"rmse_vm_mps", number(score.rmse_vm_mps)},
          {"rmse_r_degps", number(score.rmse_r_degps)},
          {"rmse_position_m", number(score.rmse_position_m)}};
}

Json to_json(const Scores& scores) {
  const auto shown = scores.free_runs.find(kShownHorizon_s);
  Json result = to_json(shown != scores.free_runs.end() ? shown->second : Score{});
  result["horizon_s"] = kShownHorizon_s;
  result["log_likelihood_per_sample"] = number(scores.log_likelihood_per_sample);
  result["coverage"] = Json::object();
  for (const auto& [percent, share] : scores.coverage) result["coverage"][std::to_string(percent)] = number(share);
  result["free_runs"] = Json::object();
  for (const auto& [horizon_s, score] : scores.free_runs)
    result["free_runs"][std::to_string(horizon_s)] = to_json(score);
  result["recordings"] = Json::object();
  for (const auto& [name, score] : scores.by_recording) result["recordings"][name] = to_json(score);
  return result;
}

Json to_json(const Explained& hypothesis) {
  Json parameters = Json::object();
  for (const ExplainedParameter& p : hypothesis.parameters) {
    Json one{{"effect", p.effect},
             {"estimate", number(p.estimate)},
             {"sd", number(p.sd)},
             {"ci95", {number(p.low), number(p.high)}},
             {"prior95", {number(p.prior_low), number(p.prior_high)}},
             {"unit", unit_of(p.name)},
             {"at_bound", p.is_at_bound}};
    // Two effects may have parameters of the same name.
    const bool is_taken = parameters.contains(p.name) && parameters[p.name]["effect"] != p.effect;
    Json& place = parameters[is_taken ? p.effect + "." + p.name : p.name];
    if (p.recording.empty() || place.is_null()) place = one;
    if (!p.recording.empty()) place["recordings"][p.recording] = one;
  }
  return {{"name", hypothesis.name},
          {"effects", hypothesis.effects},
          {"probability", number(hypothesis.probability)},
          {"log_evidence", number(hypothesis.log_evidence)},
          {"heldout_gain_nats", number(hypothesis.heldout_gain)},
          {"heldout_gain_sd_nats", number(hypothesis.heldout_gain_sd)},
          {"converged", hypothesis.converged},
          {"chosen", hypothesis.is_chosen},
          {"parameters", parameters},
          {"confusable_with", hypothesis.confusable_with},
          {"separating_maneuver", hypothesis.separating_maneuver},
          {"sentence", hypothesis.sentence}};
}

std::string_view word(ShipFileState state) {
  switch (state) {
    case ShipFileState::as_stated:
      return "as-stated";
    case ShipFileState::off:
      return "off";
    case ShipFileState::cannot_tell:
      break;
  }
  return "cannot-tell";
}

Json to_json(const ShipFile& file) {
  Json findings = Json::array();
  for (const ShipFileFinding& f : file.findings)
    findings.push_back({{"name", f.name},
                        {"factor", number(f.by.factor)},
                        {"ci95", {number(f.by.low), number(f.by.high)}},
                        {"stated_log_sd", number(f.stated_log_sd)},
                        {"heldout_gain", number(f.heldout_gain)},
                        {"sentence", f.sentence}});
  return {{"state", word(file.state)},
          {"sentence", file.sentence},
          {"heldout_gain", number(file.heldout_gain)},
          {"heldout_gain_sd", number(file.heldout_gain_sd)},
          {"findings", findings}};
}

Json argument_of(const LatentForce& kind) {
  Json axes = Json::array();
  for (const int axis : kind.axes) axes.push_back(kAxisNames[static_cast<std::size_t>(axis)]);
  Json result{{"axes", axes}};
  if (!kind.states.empty()) {
    result["states"] = Json::array();
    for (const Channel state : kind.states) result["states"].push_back(column_name(state));
  }
  if (kind.on == Dependence::place) result["length_m"] = number(kind.argument);
  if (kind.about) result["x0_m"] = kind.about->x(), result["y0_m"] = kind.about->y();
  if (kind.on == Dependence::period || kind.rings) result["period_s"] = number(kind.argument);
  if (kind.on == Dependence::memory && !kind.rings) result["fades_in_s"] = number(kind.argument);
  return result;
}

Json to_json(const LatentForce& kind) {
  return {{"kind", word(kind.on)}, {"argument", argument_of(kind)}, {"log_evidence", number(kind.log_evidence)}};
}

// What the analysis said of simulated campaigns, by what acted in them.
Json to_json(const Bootstrap& bootstrap) {
  struct OfTruth {
    std::size_t campaigns = 0, first = 0, claimed = 0, alarms = 0, undecided = 0;
    double stated = 0.0;
  };
  std::map<std::vector<std::string>, OfTruth> truths;
  OfTruth all;
  double stated_of_first = 0.0;
  for (const SimulatedAnswer& one : bootstrap.campaigns) {
    stated_of_first += one.stated_of_first;
    for (OfTruth* of : {&truths[one.truth], &all}) {
      ++of->campaigns;
      of->first += one.truth_is_first ? 1 : 0;
      of->claimed += one.truth_is_claimed ? 1 : 0;
      of->alarms += one.alarms ? 1 : 0;
      of->undecided += one.verdict == Verdict::undecided ? 1 : 0;
      of->stated += one.stated_of_truth;
    }
  }
  Json by_truth = Json::array();
  std::vector<std::pair<std::vector<std::string>, OfTruth>> order(truths.begin(), truths.end());
  std::ranges::stable_sort(order, std::greater(), [](const auto& one) { return one.second.campaigns; });
  for (const auto& [names, of] : order)
    by_truth.push_back({{"names", names},
                        {"campaigns", of.campaigns},
                        {"first", of.first},
                        {"claimed", of.claimed},
                        {"mismatch", of.alarms},
                        {"undecided", of.undecided},
                        {"stated_of_truth", number(of.stated / static_cast<double>(of.campaigns))}});
  return {{"campaigns", all.campaigns},
          {"failed", bootstrap.failed},
          {"first_is_right", all.first},
          {"stated_of_first", number(stated_of_first / static_cast<double>(all.campaigns))},
          {"sharpness", number(bootstrap.sharpness)},
          {"not_fitted", number(bootstrap.not_fitted)},
          {"truths", by_truth}};
}

// How probable it is that each effect or fault acts, and that a coefficient is off: over all hypotheses that have it.
Json advised_by(const NextPlan& plan, double p_right) {
  const Recommended best = recommended(plan, p_right);
  Json maneuvers = Json::array(), record;
  if (best.what == Recommended::What::maneuver) maneuvers.push_back(plan.maneuvers[best.place].name);
  if (best.what == Recommended::What::sequence)
    for (const std::size_t place : plan.sequences[best.place].maneuvers)
      maneuvers.push_back(plan.maneuvers[place].name);
  if (best.what == Recommended::What::record) {
    record = plan.records[best.place].what;
    if (!plan.records[best.place].maneuver.empty()) maneuvers.push_back(plan.records[best.place].maneuver);
  }
  return {{"nothing_tells", best.what == Recommended::What::nothing},
          {"maneuvers", maneuvers},
          {"record", record},
          {"p_right", number(best.p_right)}};
}

Json next_of(const Explanation& explanation) {
  const NextPlan plan = explanation.next.value_or(NextPlan());
  const std::string ship = explanation.findings.called.ship.empty() ? "SHIP.json" : explanation.findings.called.ship;
  Json maneuvers = Json::array(), sequences = Json::array(), records = Json::array();
  for (const NextManeuver& maneuver : plan.maneuvers)
    maneuvers.push_back({{"maneuver", maneuver.name},
                         {"command", fmt::format("mmg-sim {} --ship {} -o planned.csv", maneuver.command, ship)},
                         {"duration_s", maneuver.duration_s},
                         {"p_right", number(maneuver.p_right)}});
  for (const NextSequence& both : plan.sequences) {
    const auto [first, second] = both.maneuvers;
    sequences.push_back({{"maneuvers", {plan.maneuvers[first].name, plan.maneuvers[second].name}},
                         {"duration_s", both.duration_s},
                         {"p_right", number(both.p_right)}});
  }
  for (const NextRecord& record : plan.records)
    records.push_back({{"record", record.what},
                       {"maneuver", record.maneuver.empty() ? Json() : Json(record.maneuver)},
                       {"p_right", number(record.p_right)}});
  const NextLimits& limits = plan.limits;
  return {{"p_right_now", number(explanation.p_right)},
          {"p_reachable", explanation.next ? number(plan.p_reachable) : Json()},
          {"advised", explanation.next ? advised_by(plan, explanation.p_right) : Json()},
          {"maneuvers", maneuvers},
          {"sequences", sequences},
          {"records", records},
          {"limits",
           {{"length_m", number(limits.length_m.value_or(kMissing))},
            {"width_m", number(limits.width_m.value_or(kMissing))},
            {"depth_m", number(limits.depth_m.value_or(kMissing))},
            {"rudder_deg", number(limits.rudder_deg.value_or(kMissing))},
            {"time_s", number(limits.time_s.value_or(kMissing))}}}};
}

Json inclusion_of(const Explanation& explanation) {
  Json result = Json::object();
  for (const auto& [name, probability] : inclusion(explanation))
    if (!name.starts_with(coefficient_in_inclusion("")) || probability > kPolicy.show.possible)
      result[name] = number(probability);
  return result;
}

}  // namespace

Json to_json(const Explanation& explanation) {
  Json kinds = Json::array();
  for (const LatentForce& kind : explanation.unknown_kinds) kinds.push_back(to_json(kind));
  const LatentForce* kind = unknown_kind(explanation);
  Json modules = Json::object();
  for (const CalibratedModule& module : explanation.ship_file.modules) modules[module.name] = number(module.gain);
  Json beyond;
  if (const auto& b = explanation.beyond_recorded)
    beyond = {{"recorded_rudder_deg", number(b->recorded_deg)},
              {"rudder_deg", number(b->rudder_deg)},
              {"tactical_diameter_L", number(b->diameter_L)},
              {"ci95", {number(b->low_L), number(b->high_L)}}};
  Json locate = to_json(explanation.findings), hypotheses = Json::array(), sets = Json::array();
  for (const Explained& hypothesis : explanation.hypotheses) hypotheses.push_back(to_json(hypothesis));
  for (const ProbableSet& set : probable_sets(explanation))
    sets.push_back({{"names", set.names}, {"probability", number(set.probability)}, {"in_95", set.is_credible}});
  Json ships = Json::object();
  for (const auto& [recording, effects] : explanation.effects_in) ships[recording] = ship_file(recording);
  Json currents = Json::object();
  for (const CurrentPath& path : explanation.current_paths) currents[path.recording] = current_file(path.recording);
  Json factors = Json::object();
  Json differences = Json::object();
  for (const CoefficientFactor& by : explanation.coefficient_factors)
    (by.shift != 0.0 ? differences : factors)[by.name] = number(by.shift != 0.0 ? by.shift : by.factor);
  return {
      {"ship_name", explanation.findings.ship},
      {"verdict", word(explanation.verdict)},
      {"p_value", number(explanation.p_value)},
      {"sentence", headline(explanation)},
      {"located", locate["located"]},
      {"ship_file", to_json(explanation.ship_file)},
      {"modules", modules},
      {"hypotheses", hypotheses},
      {"inclusion", inclusion_of(explanation)},
      {"bootstrap", explanation.bootstrap ? to_json(*explanation.bootstrap) : Json()},
      {"sets", sets},
      {"not_fitted", number(explanation.hypotheses.empty() ? kMissing : not_fitted(explanation))},
      {"chosen", explanation.chosen},
      {"unknown_kind", kind != nullptr ? Json(word(kind->on)) : Json()},
      {"unknown_argument", kind != nullptr ? argument_of(*kind) : Json()},
      {"unknown_kinds", kinds},
      {"is_complete", explanation.is_complete},
      {"left_p_value", number(explanation.left_p_value)},
      {"heldout_gain_nats", number(explanation.heldout_gain)},
      {"heldout_gain_sd_nats", number(explanation.heldout_gain_sd)},
      {"heldout_is_given", explanation.heldout_is_given},
      {"fit",
       {{"train", {{"before", to_json(explanation.train.before)}, {"after", to_json(explanation.train.after)}}},
        {"heldout", {{"before", to_json(explanation.heldout.before)}, {"after", to_json(explanation.heldout.after)}}}}},
      {"next", next_of(explanation)},
      {"residual_network",
       {{"in_ship", explanation.residual_network != nullptr},
        {"log_error_without", number(explanation.log_error_without_network)},
        {"log_error_with", number(explanation.log_error_with_network)}}},
      {"coefficient_factors", factors},
      {"coefficient_shifts", differences},
      {"beyond_recorded", beyond},
      {"ship", "ship.json"},
      {"currents", currents},
      {"ships", ships},
      {"parameters", to_json(explanation.parameters)},
      {"parameters_before", locate["null_fit"]["parameters"]},
      {"sigma_w", locate["sigma_w"]},
      {"audit", locate["audit"]},
      {"conventions", locate["conventions"]},
      {"notices", explanation.notices}};
}

std::string current_file(const std::string& recording) { return "current-" + recording + ".csv"; }

std::string ship_file(const std::string& recording) { return "ship-" + recording + ".json"; }

namespace {

std::vector<std::string> recordings_of(const Explanation& explanation) {
  std::vector<std::string> names;
  for (const Residual& recording : explanation.findings.residuals)
    if (std::ranges::find(names, recording.recording) == names.end()) names.push_back(recording.recording);
  return names;
}

}  // namespace

Json ship_with(Json of, const Explanation& explanation, const std::string& recording) {
  const std::vector<EffectEntry>& effects =
      recording.empty() ? explanation.effects : explanation.effects_in.at(recording);
  const bool is_changed = explanation.calibration || explanation.residual_network ||
                          !explanation.coefficient_factors.empty() || !effects.empty();
  if (is_changed && of.contains("name") && of["name"].is_string()) {  // it is another ship: results carry its name
    if (const std::string ship = of["name"], more = recording.empty() ? ", fitted" : ", fitted to " + recording;
        !ship.ends_with(more))
      of["name"] = ship + more;
  }
  if (explanation.residual_network) of["residual_network"] = to_json(*explanation.residual_network);
  of = multiplied(std::move(of), explanation.coefficient_factors,
                  "estimated by gap-explain from recordings; standard deviations in its report.json");
  if (explanation.calibration)
    of["coefficient_covariance"] =
        to_json(explanation.calibration->covariance,
                fmt::format("what these recordings leave open of what the ship file stated, times {:.2g}: {}",
                            explanation.calibration->scale, fmt::join(recordings_of(explanation), ", ")));
  if (effects.empty()) return of;
  if (!of.contains("effects")) of["effects"] = Json::array();
  for (const EffectEntry& entry : effects) {
    Json effect{{"type", entry.type}};
    for (const auto& [name, value] : entry.parameters)
      if (!value || std::isfinite(*value)) effect[name] = value ? Json(*value) : Json(nullptr);
    effect["source"] = "estimated by gap-explain from recordings; intervals in its report.json";
    of["effects"].push_back(std::move(effect));
  }
  return of;
}

}  // namespace leeway::gap
