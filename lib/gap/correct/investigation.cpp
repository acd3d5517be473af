#include "gap/correct/investigation.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "gap/compare/latent_forces.hpp"
#include "gap/correct/faults.hpp"
#include "gap/correct/seen_faults.hpp"
#include "gap/correct/sensed.hpp"
#include "gap/correct/wind_reading.hpp"
#include "gap/decide/decide.hpp"
#include "gap/decide/sensors.hpp"
#include "gap/detect/detect.hpp"
#include "gap/detect/gains_of_nothing.hpp"
#include "gap/detect/helm.hpp"
#include "gap/sensors/audit.hpp"
#include "gap/sensors/channel_quality.hpp"
#include "gap/sensors/conventions.hpp"
#include "ship/pitch_current.hpp"

namespace leeway::gap {
namespace {

// Effects that were not tested, and why.
std::vector<std::string> untested_of(const EffectLibrary& library, const Detection& detection) {
  std::vector<std::string> untested = library.not_applicable(), silent;
  for (const EffectLibrary::Entry& entry : library.entries())
    if (std::none_of(detection.effects.begin(), detection.effects.end(),
                     [&](const Screened& s) { return s.name == entry.name; }))
      silent.push_back(entry.name);
  if (!silent.empty())
    untested.push_back(
        fmt::format("{}: not excited, of the wrong sign, or no more than the ship's own parameters may do",
                    fmt::join(silent, ", ")));
  return untested;
}

// How well the ensemble knows these recordings in all.
EnsembleUsed use_of(const EnsembleSimulator& simulator, const FittedNull& fit) {
  const ensemble::EnsembleHeader& header = simulator.ensemble().header();
  EnsembleUsed used{simulator.name(),
                    simulator.ensemble().members(),
                    header.config.time_step_s,
                    header.base ? header.base->name : "",
                    0.0,
                    Vec3<double>::Zero()};
  double n = 0.0;
  for (const LinearStretch& stretch : fit.stretches)
    for (const LinearStep& step : stretch.steps) {
      used.outside_share += step.beyond > 0.0 ? 1.0 : 0.0;
      used.spread += step.spread.diagonal();
      n += 1.0;
    }
  used.outside_share /= n;
  used.spread = (used.spread / n).cwiseSqrt();
  return used;
}

}  // namespace

Investigator::Investigator(const Ship& ship, std::shared_ptr<const EnsembleSimulator> ensemble,
                           std::vector<Trajectory>& recordings, const GapLocateOptions& options)
    : ship_(ship),
      scale_(ship.particulars.L_pp),
      ensemble_(std::move(ensemble)),
      recordings_(recordings),
      options_(options),
      campaign_options_{options.step_s, 0.0, ensemble_} {
  result.findings.ship = ship.name;
  result.findings.L_pp = ship.particulars.L_pp;
  fit_options_.jobs = options.jobs;
  fit_options_.progress = [this](double done, const std::string& note) { progress(0.10 + 0.5 * done, note); };
  add_revolutions(recordings, ship);
  prepare(ship, recordings, campaign_options_);  // what cannot be used is said before the long work
}

void Investigator::progress(double done, const std::string& note) const {
  if (options_.progress) options_.progress(done, note);
}

std::vector<Trajectory> Investigator::moving(const std::vector<Trajectory>& recordings) const {
  std::vector<Trajectory> moving;
  moving.reserve(recordings.size());
  for (const Trajectory& recording : recordings) moving.push_back(without_frozen(recording, scale_));
  return moving;
}

void Investigator::correct(const std::vector<Fault>& faults) {
  recordings_ = reread_;
  for (Trajectory& recording : recordings_) recording = corrected(recording, faults, scale_);
}

bool Investigator::is_corrected() const {
  return !result.findings.audit.faults.empty() || !result.findings.conventions.contradicted.empty();
}

void Investigator::check_conventions() {
  progress(0.0, "conventions");
  Conventions& conventions = result.findings.conventions;
  std::vector<Trajectory> recordings = moving(recordings_);
  std::erase_if(recordings, is_at_rest);
  conventions = ensemble_ ? check_motion(ship_, recordings) : gap::check_conventions(ship_, recordings);
  if (recordings_.size() > 1 && !ensemble_)
    for (Reading& reading : contradicted_in_one(ship_, recordings, conventions, options_.jobs))
      conventions.contradicted.push_back(std::move(reading));
  // A contradicted convention would show as faults of every kind; it is read as it fits before.
  for (const Trajectory& recording : recordings_) reread_.push_back(reread(recording, conventions.contradicted));
}

void Investigator::audit_sensors() {
  progress(0.03, "audit of the sensors");
  Findings& findings = result.findings;
  AuditOptions audit_options;
  audit_options.scale = scale_;
  audit_options.false_alarm = options_.false_alarm / kPolicy.decide.families;
  audit_options.jobs = options_.jobs;
  audit_options.seed = options_.seed;
  findings.audit = audit(reread_, audit_options);
  share_rate(findings.audit);
  certain_ = findings.audit.faults;
  std::erase_if(certain_, [&](const Fault& f) { return is_faint(f, options_.false_alarm) && is_early(f); });
  withdraw(findings, certain_, "sensors are late, not early");
  findings.corrected = options_.correct && is_corrected();
  if (findings.corrected) correct(findings.audit.faults);
}

void Investigator::fit_anew(const FittedNull* near_by) {
  progress(0.10, "fit within the stated uncertainty");
  result.campaign = with_free_faults(prepare(ship_, moving(recordings_), campaign_options_), result.null,
                                     result.findings.audit.faults);
  result.null = fit_null(result.campaign, fit_options_, near_by);
  // Where a course is kept rudders are no inputs, but follow the ship.
  if (!ensemble_)
    if (std::optional<Campaign> kept = with_helms(result.campaign, result.null.smoothed)) {
      result.campaign = *std::move(kept);
      result.null = fit_null(result.campaign, fit_options_);
    }
  result.campaign = without_outliers(std::move(result.campaign), result.null);
  result.findings.fit = result.null.report;
  if (ensemble_) result.findings.ensemble = use_of(*ensemble_, result.null);
}

void Investigator::fit() { fit_anew(); }

void Investigator::withdraw_faint_faults() {
  Findings& findings = result.findings;
  std::erase_if(certain_, [&](const Fault& f) { return is_faint(f, options_.false_alarm) && can_be_compared(f); });
  if (!findings.corrected || ensemble_ || certain_.size() >= findings.audit.faults.size()) return;
  const SensedCampaign sensed(prepare(ship_, moving(reread_), campaign_options_), result.null, scale_, options_.jobs);
  std::vector<Fault> all = findings.audit.faults, without = certain_;
  const std::optional<double> of_all = sensed.fit(all), of_certain = sensed.fit(without);
  const double gained = of_all && of_certain ? *of_certain - *of_all : 0.0;
  correct(certain_);
  fit_anew();
  if (gained > kPolicy.decide.contradicted) {
    withdraw(findings, std::move(certain_),
             fmt::format("the simulator follows the recordings better without it (log-odds {:.0f})", gained));
    findings.corrected = is_corrected();
  } else {
    judge_by_forces(findings.audit.faults);
    correct(findings.audit.faults);
    fit_anew();
  }
}

void Investigator::judge_by_forces(std::vector<Fault>& faults) const {
  const SeenFaults seen = seen_faults(result.campaign, result.null, options_.jobs, options_.seed);
  if (seen.gains_of_nothing.empty()) return;
  for (const SeenFault& one : seen.faults)
    for (Fault& fault : faults)
      if (fault.name == one.fault.name)
        fault.p_value = std::min(fault.p_value,
                                 kPolicy.decide.families * chance_of_gain(seen.gains_of_nothing, one.log_bayes_factor));
}

void Investigator::identify_faults() {
  Findings& findings = result.findings;
  std::vector<Fault>& faults = findings.audit.faults;
  while (options_.correct && !ensemble_ && findings.audit.is_checked && faults.size() < kPolicy.sensors.most_faults) {
    const SeenFaults seen = seen_faults(result.campaign, result.null, options_.jobs, options_.seed);
    const std::optional<Fault> likeliest = likeliest_of(seen.faults, faults);
    if (!likeliest || seen.gains_of_nothing.empty()) return;
    const double rate = options_.false_alarm / kPolicy.decide.families;
    FaultOdds odds{.log_bayes_factor = likeliest->log_odds,
                   .chance = chance_of_gain(seen.gains_of_nothing, likeliest->log_odds),
                   .heldout_gain = likeliest->heldout_gain,
                   .heldout_gain_sd = likeliest->heldout_gain_sd};
    // The forces in its place are fitted where it matters alone.
    if (!is_identified(odds, rate)) return;
    odds.of_best_force = best_evidence(result.campaign, result.null, options_) - log_evidence(result.null);
    for (const LatentForce& latent : latent_forces(result.campaign, result.null, options_.jobs))
      odds.of_best_force = std::max(odds.of_best_force, latent.log_evidence);
    if (!is_identified(odds, rate)) return;
    faults.push_back(*likeliest);
    faults.back().p_value = std::min(1.0, kPolicy.decide.families * odds.chance);
    faults.back().log_odds = 0.0;
    findings.audit.notices.push_back(
        fmt::format("{}: the kinematics alone leave it open, but with it the simulator follows the recordings better "
                    "(log-odds {:.0f})",
                    likeliest->name, likeliest->log_odds));
    findings.corrected = true;
    correct(faults);
    fit_anew();
  }
}

void Investigator::refine_faults() {
  std::vector<Fault>& faults = result.findings.audit.faults;
  if (!options_.correct || ensemble_ || faults.empty()) return;
  std::vector<std::string>& notices = result.findings.audit.notices;
  for (const Fault& fault : faults)
    if (const std::optional<std::string> notice = rivals_notice(fault)) std::erase(notices, *notice);
  const SensedCampaign sensed(prepare(ship_, moving(reread_), campaign_options_), result.null, scale_, options_.jobs);
  refine(faults, result.findings.audit.hypotheses, [&](std::vector<Fault>& tried) { return sensed.fit(tried); });
  for (const Fault& fault : faults)
    if (const std::optional<std::string> notice = rivals_notice(fault)) notices.push_back(*notice);
  correct(faults);
  const FittedNull near_by = result.null;
  fit_anew(&near_by);
}

void Investigator::test_effects() {
  progress(0.60, "effects of the catalogue");
  const EffectLibrary library(result.campaign, result.null);
  DetectOptions detect_options;
  detect_options.false_alarm = options_.false_alarm;
  detect_options.jobs = options_.jobs;
  detect_options.seed = options_.seed;
  result.findings.detection = detect(result.campaign, result.null, library, detect_options);
  result.findings.detection.untested = untested_of(library, result.findings.detection);
}

void Investigator::reread_wind() {
  Findings& findings = result.findings;
  if (!(findings.detection.p_value < options_.false_alarm) || ensemble_) return;
  const std::optional<Reading> reading = wind_reading(result.campaign, result.null, findings.conventions, options_);
  if (!reading) return;
  findings.conventions.contradicted.push_back(*reading);
  if (!options_.correct) return;
  findings.corrected = true;
  for (Trajectory& recording : recordings_) recording = reread(recording, {*reading});
  fit_anew();
  test_effects();
}

}  // namespace leeway::gap
