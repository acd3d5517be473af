#include "gap/gap_locate.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.hpp"
#include "gap/channel_quality.hpp"
#include "gap/comparison.hpp"
#include "gap/detect.hpp"
#include "gap/locate.hpp"
#include "gap/screen.hpp"

namespace leeway::gap {
namespace {

constexpr double kNotWhite = 0.25;        // autocorrelation of the innovations that the noise model should not leave
constexpr double kErrsAsMuch = 0.7;       // model error by typical acceleration: then little is predicted at all
constexpr double kFarParameter_sd = 4.0;  // of what is stated: a parameter farther off stands for something else
constexpr std::size_t kFewestSamples = 300;
constexpr double kFamilies = 3.0;  // of tests: of the sensors, for effects, for intervals
// How often tests alarm where nothing is missing, by their rate: p-values take the model error as random, and that of
// simulators with other formulas is not (docs/proof.md, 500 cases).
constexpr double kAlarmsByRate = 2.5;
constexpr double kTests = kFamilies * kAlarmsByRate;  // by which p-values of one test become those of all
constexpr double kNearly = 5.0;           // p-values up to this times the rate of false alarms leave it open
constexpr double kOpen = 3.0;             // log-odds of a reading that short times do not decide
constexpr double kContradicted = 3.0;     // nats by which recordings are likelier without a faint fault
constexpr double kFarLikelier = 10.0;     // log-odds by which a fit contradicts a convention
constexpr std::size_t kMostCompared = 3;  // effects that may be missing instead
constexpr double kSuspected = 0.2;        // p-value of a fault that the simulator is asked about
constexpr std::size_t kMostSuspects = 2;

// The verdict with the reason for it.
void judge(Findings& findings, double scan_p_value) {
  Detection& d = findings.detection;
  const NullFit& fit = findings.fit;
  const double library_p = d.p_value;
  d.p_value = std::min(1.0, kTests * std::min(library_p, scan_p_value));
  const bool by_interval = scan_p_value < library_p;
  const bool improves = d.heldout_gain > 2.0 * d.heldout_gain_sd ||
                        (d.heldout_gain > d.heldout_gain_sd && d.p_value < d.false_alarm * d.false_alarm);
  const double share = fit.sigma_w.cwiseQuotient(fit.typical.cwiseMax(1e-12)).maxCoeff();
  // Then inputs that are known at the samples alone are the larger error, and what the tests see may be that.
  const auto untrained = std::count_if(findings.located.intervals.begin(), findings.located.intervals.end(),
                                       [](const Interval& interval) { return interval.is_untrained(); });
  const auto small = std::count_if(findings.located.intervals.begin(), findings.located.intervals.end(),
                                   [](const Interval& i) { return i.is_small && !i.is_untrained(); });
  const std::string simulator = findings.ensemble ? "ensemble" : "simulator";
  const bool is_of_inputs = fit.is_noise_free && share < kErrorOfInputs;
  const std::string rate = fmt::format("{:.3g} %", 100.0 * d.false_alarm);

  if (!fit.converged) {
    findings.verdict = Verdict::undecided;
    d.reason = "the fit of the simulator's parameters did not come to rest, so nothing can be concluded from it";
  } else if (d.p_value < kNearly * d.false_alarm && is_of_inputs) {
    findings.verdict = Verdict::undecided;
    d.reason = fmt::format(
        "the recordings show no noise, as simulated ones, and the simulator errs by {:.1f} % of the typical "
        "acceleration: so much comes from inputs that are known at the samples alone",
        100.0 * share);
  } else if (d.p_value < d.false_alarm && by_interval) {
    findings.verdict = Verdict::mismatch;
    d.reason = fmt::format(
        "something acts in an interval that the {} does not know; by chance this would be "
        "seen in fewer than {} of campaigns",
        simulator, rate);
  } else if (d.p_value < d.false_alarm && improves) {
    findings.verdict = Verdict::mismatch;
    d.reason = fmt::format(
        "accelerations as of '{}' remain that {} explains, and adding them predicts what was held out better",
        d.effects.front().name,
        findings.ensemble ? "neither the members' spread nor random model error"
                          : "no parameter within its uncertainty");
  } else if (d.p_value < d.false_alarm) {
    findings.verdict = Verdict::undecided;
    d.reason = fmt::format(
        "accelerations as of '{}' remain, but adding them does not predict held-out parts better; more "
        "recordings would tell",
        d.effects.front().name);
  } else if (d.p_value < kNearly * d.false_alarm) {
    findings.verdict = Verdict::undecided;
    d.reason =
        fmt::format("the evidence is close to the stated rate of false alarms ({}); more recordings would tell", rate);
  } else if (small > 0) {
    findings.verdict = Verdict::undecided;
    d.reason = fmt::format(
        "what acts in {} interval{} is less than a fifth of the typical acceleration: so much the form of the {}'s "
        "forces may make",
        small, small > 1 ? "s" : "", simulator);
  } else if (untrained > 0) {
    findings.verdict = Verdict::undecided;
    d.reason = fmt::format(
        "all significant mismatch lies in {} interval{} for which the ensemble was not trained; what it misses there "
        "may be nothing but that",
        untrained, untrained > 1 ? "s" : "");
  } else if (fit.samples < kFewestSamples) {
    findings.verdict = Verdict::undecided;
    d.reason =
        fmt::format("{} measurements are too few to exclude anything; longer recordings would tell", fit.samples);
  } else if (d.effects.empty()) {
    findings.verdict = Verdict::undecided;
    d.reason = "the recordings excite none of the effects of the catalogue; longer or livelier maneuvers would";
  } else if (share > kErrsAsMuch) {
    findings.verdict = Verdict::undecided;
    d.reason = fmt::format(
        "the {} errs by {:.0f} % of the typical acceleration, in a way that no effect of the "
        "catalogue explains",
        simulator, 100.0 * share);
  } else if (!is_of_inputs && d.largest_autocorrelation > kNotWhite && d.whiteness_p_value < 1e-6) {
    findings.verdict = Verdict::undecided;
    d.reason =
        fmt::format("what is left is not white noise (correlation {:.2f}), so that small effects cannot be excluded",
                    d.largest_autocorrelation);
  } else if (errs_grossly(fit)) {
    findings.verdict = Verdict::undecided;
    d.reason = "coefficients had to move far beyond what is stated, and may hide something";
  } else {
    findings.verdict = Verdict::no_mismatch;
    d.reason = fmt::format("what remains is what {} and random model error leave",
                           findings.ensemble ? "the members' spread" : "parameters within their uncertainty");
  }
  d.reason.front() = static_cast<char>(std::toupper(d.reason.front()));
  d.reason += '.';
}

std::string another_ship(const Ship& ship) {
  return fmt::format(
      "parameters moved by more than {:.0f} sd of what is stated, and no effect of the catalogue brings them back; are "
      "these recordings of the ship '{}'?",
      kFarParameter_sd, ship.name);
}

}  // namespace

bool errs_grossly(const NullFit& fit) {
  const auto far = std::count_if(fit.parameters.begin(), fit.parameters.end(), [](const ParameterShift& shift) {
    return std::abs(shift.shift_sd) > kFarParameter_sd;
  });
  const double share = fit.sigma_w.cwiseQuotient(fit.typical.cwiseMax(1e-12)).maxCoeff();
  return far >= 4 || (far >= 2 && share > 0.5);
}

namespace {

// Whether this looks like another ship: parameters far off that neither repaired sensors nor the best effect of the
// catalogue bring back.
bool is_grossly_inconsistent(const Findings& findings, Campaign& campaign, const FittedNull& null, std::size_t jobs) {
  if (!findings.corrected && (!findings.audit.faults.empty() || !findings.conventions.contradicted.empty()))
    return false;
  if (!errs_grossly(null.report) || findings.detection.effects.empty()) return errs_grossly(null.report);
  const std::vector<Start> starts = starts_of(findings.detection.effects.front().name, campaign, null, jobs);
  FitOptions options;
  options.jobs = jobs;
  try {
    return errs_grossly(fit_with(campaign, null, starts.front().hypothesis, starts.front().theta, options).report);
  } catch (const NumericalError&) {  // with the effect the simulator runs away: it brings nothing back
    return true;
  }
}

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

void add_notices(Findings& findings, const Campaign& campaign) {
  std::vector<std::string>& notices = findings.notices;
  const NullFit& fit = findings.fit;
  for (const Trajectory& recording : campaign.recordings)
    for (const std::string& sentence : suspect_actuators(recording))
      notices.push_back(recording.file + ": " + sentence);
  notices.insert(notices.end(), campaign.notices.begin(), campaign.notices.end());
  if (fit.outliers > 0)
    notices.push_back(
        fmt::format("{} of {} measurements lay more than 6 sd from what the others predict and were left out",
                    fit.outliers, fit.samples + fit.outliers));
  if (fit.is_noise_free)
    notices.push_back(
        fmt::format("u, v_m and r show no noise, as simulated recordings: differences below {:.0f} % of the typical "
                    "acceleration are not judged",
                    100.0 * kErrorOfInputs));
  if (!campaign.has_position)
    notices.push_back("no positions: slow effects show two to four times less; record x0_m and y0_m");
  if (!campaign.has_heading) notices.push_back("no heading: effects with a direction in earth axes cannot be seen");
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

void add_ensemble_notices(const EnsembleSimulator& simulator, Findings& findings) {
  const ensemble::EnsembleHeader& header = simulator.ensemble().header();
  if (simulator.ensemble().members() < 2)
    findings.notices.emplace_back("a single member has no spread: it cannot tell what it was not trained for");
  if (header.inputs.domain.empty())
    findings.notices.emplace_back("the ensemble does not say what its training data covered; train it anew to know");
  for (const std::string& notice : simulator.ensemble().notices()) findings.notices.push_back(notice);
}

// Of the best of nothing and the effects that promise most, fitted.
double best_evidence(Campaign campaign, const FittedNull& near_by, const GapLocateOptions& options) {
  const FittedNull none = follow(campaign, near_by, {}, options.jobs);
  Comparison comparison(campaign, none, {options.false_alarm, options.jobs});
  double best = comparison.none().log_evidence;
  const std::vector<Comparison::Promise> promises = comparison.promises(0);
  for (std::size_t i = 0; i < std::min(promises.size(), kMostCompared); ++i)
    if (const auto added = comparison.add(0, promises[i].starts))
      best = std::max(best, comparison.all()[*added].log_evidence);
  return best;
}

// A wind that is weak against the ship's forces is not told from one that reads otherwise over short times, but by the
// fit: the reading under which all is far likelier, at the coefficients and noise levels of the fit as stated. Waves
// that come against the wind look like one: it has to be likelier also where one effect may be missing.
std::optional<Reading> told_by_fit(const Campaign& campaign, const FittedNull& fit, const Conventions& conventions,
                                   const GapLocateOptions& options) {
  std::optional<Reading> result;
  Campaign best;
  const double as_stated = log_evidence(fit);
  double least = kFarLikelier;
  for (const Reading& reading : conventions.tested) {
    const bool is_wind = reading.recording.empty() && (reading.name == "wind-to" || reading.name == "apparent");
    if (!campaign.has_wind || !is_wind || reading.log_odds < -kOpen) continue;
    Campaign otherwise = campaign;
    for (std::size_t r = 0; r < campaign.recordings.size(); ++r) {
      otherwise.recordings[r] = reread(campaign.recordings[r], {reading});
      otherwise.recorded_inputs[r] = RecordedInputs(otherwise.recordings[r], campaign.ship, InputInterpolation::linear);
    }
    const RudderResponse response = Effects<double>(campaign.ship).rudder_response();
    for (Stretch& stretch : otherwise.stretches)
      set_inputs(stretch, otherwise.recorded_inputs[stretch.recording].through(response), campaign.ship);
    const double gained = log_evidence(follow(otherwise, fit, {}, options.jobs)) - as_stated;
    if (!(gained > least)) continue;  // nor where it cannot be told
    least = gained;
    best = std::move(otherwise);
    result = reading;
    result->log_odds = gained;
    result->sentence = fmt::format("{}, the recordings are likelier than as stated (log-odds {:.0f})",
                                   reading.sentence.substr(0, reading.sentence.find(',')), gained);
  }
  if (!result) return result;
  const double limit = best_evidence(campaign, fit, options) + kFarLikelier;
  if (as_stated + least < limit && best_evidence(std::move(best), fit, options) < limit) result.reset();
  return result;
}

// Faults with the p-values of all families of tests.
void share_rate(Audit& audit) {
  for (std::vector<Fault>* faults : {&audit.faults, &audit.hypotheses})
    for (Fault& fault : *faults) {
      fault.p_value = std::min(1.0, kTests * fault.p_value);
      for (Fault& rival : fault.rivals) rival.p_value = std::min(1.0, kTests * rival.p_value);
    }
}

// A fault that noise feigns in one of some hundred campaigns.
bool is_faint(const Fault& fault, double false_alarm) { return fault.p_value >= kTests * false_alarm * false_alarm; }

// Sensors are late, not early; positions that are early stand for all others that are late.
bool is_early(const Fault& fault) {
  return fault.name.ends_with("-latency") && fault.name != "position-latency" && fault.parameters.front().value < 0.0;
}

// Likelihoods with and without a fault can be compared where taking it out does not filter a channel.
bool can_be_compared(const Fault& fault) {
  return fault.name == "lever-arm" || fault.name.ends_with("-bias") || fault.name.ends_with("-scale");
}

// Faults that the kinematics leave open, the likeliest first.
std::vector<Fault> suspects_of(const Audit& audit) {
  std::vector<Fault> suspects;
  for (const Fault& fault : audit.hypotheses) {
    const auto is_same = [&](const Fault& other) { return other.name == fault.name; };
    if (fault.p_value < kSuspected && can_be_compared(fault) && fault.heldout_gain > 0.0 &&
        std::none_of(suspects.begin(), suspects.end(), is_same))
      suspects.push_back(fault);
  }
  std::stable_sort(suspects.begin(), suspects.end(),
                   [](const Fault& a, const Fault& b) { return a.p_value < b.p_value; });
  if (suspects.size() > kMostSuspects) suspects.resize(kMostSuspects);
  return suspects;
}

// Leaves the faults that are certain.
void withdraw(Findings& findings, std::vector<Fault> certain, const std::string& why) {
  std::vector<Fault>& faults = findings.audit.faults;
  for (const Fault& fault : faults)
    if (std::none_of(certain.begin(), certain.end(), [&](const Fault& c) { return c.name == fault.name; }))
      findings.audit.notices.push_back(
          fmt::format("{} (p = {:.2g}): not so, since {}", fault.sentence, fault.p_value, why));
  faults = std::move(certain);
  if (faults.empty()) findings.audit.verdict = Audit::Verdict::consistent;
}

// ln |d corrected / d recorded|, by which the likelihood of what was recorded differs from that of what was corrected.
double log_jacobian(const std::vector<Fault>& faults, const std::vector<Trajectory>& recordings) {
  double sum = 0.0;
  for (const Fault& fault : faults)
    for (const Estimate& scale : fault.parameters) {
      const Channel channel = scale.name == "log_scale"        ? Channel::u
                              : scale.name == "sway_log_scale" ? Channel::vm
                              : scale.name == "rate_scale"     ? Channel::r
                                                               : Channel::t;
      if (channel == Channel::t) continue;
      for (const Trajectory& recording : recordings)
        sum -= std::log1p(scale.value) *
               static_cast<double>(std::count_if(recording[channel].begin(), recording[channel].end(),
                                                 [](double value) { return std::isfinite(value); }));
    }
  return sum;
}

// The numbers of faults at which the simulator follows the recordings best, within two standard errors of the audit:
// what is left of a bias looks like missing physics. A parabola in one number after the other, and once more in those
// that moved farther than it was drawn.
//   evidence_of  of nothing missing, with faults taken out
template <typename EvidenceOf>
void refine(std::vector<Fault>& faults, const EvidenceOf& evidence_of) {
  const std::vector<Fault> of_audit = faults;
  for (int round = 0; round < 2; ++round)
    for (std::size_t f = 0; f < faults.size(); ++f) {
      if (!can_be_compared(faults[f])) continue;
      std::vector<Estimate>& numbers = faults[f].parameters;
      for (std::size_t i = 0, next = 0; i < numbers.size(); i = next) {
        // Several channels may have one number.
        const Estimate now = numbers[i], &audited = of_audit[f].parameters[i];
        while (next < numbers.size() && numbers[next].value == now.value && numbers[next].sd == now.sd) ++next;
        const auto set = [&](double value) {
          for (std::size_t k = i; k < next; ++k) numbers[k].value = value;
        };
        const double step = 0.5 * now.sd;
        if (round > 0 && std::abs(now.value - audited.value) <= step) continue;
        const auto evidence_at = [&](double value) {
          set(value);
          return evidence_of(faults);
        };
        const double here = evidence_at(now.value), above = evidence_at(now.value + step),
                     below = evidence_at(now.value - step);
        const double slope = (above - below) / (2.0 * step), bend = (above + below - 2.0 * here) / (step * step);
        set(bend < 0.0 ? std::clamp(now.value - slope / bend, audited.value - 2.0 * audited.sd,
                                    audited.value + 2.0 * audited.sd)
                       : now.value);
      }
    }
  for (Fault& fault : faults)
    if (can_be_compared(fault)) retell(fault);
}

Investigation investigate(const Ship& ship, const std::shared_ptr<const EnsembleSimulator>& ensemble,
                          std::vector<Trajectory>& recordings, const GapLocateOptions& options);

}  // namespace

Findings gap_locate(const std::shared_ptr<const EnsembleSimulator>& ensemble, std::vector<Trajectory>& recordings,
                    const GapLocateOptions& options) {
  Findings findings = investigate(ensemble->ship(), ensemble, recordings, options).findings;
  if (options.progress) options.progress(1.0, "done");
  return findings;
}

Findings gap_locate(const Ship& ship, std::vector<Trajectory>& recordings, const GapLocateOptions& options) {
  Investigation investigation = investigate(ship, recordings, options);
  Findings& findings = investigation.findings;
  findings.grossly_inconsistent =
      is_grossly_inconsistent(findings, investigation.campaign, investigation.null, options.jobs);
  if (findings.grossly_inconsistent) findings.notices.insert(findings.notices.begin(), another_ship(ship));
  if (options.progress) options.progress(1.0, "done");
  return std::move(findings);
}

Investigation investigate(const Ship& ship, std::vector<Trajectory>& recordings, const GapLocateOptions& options) {
  return investigate(ship, nullptr, recordings, options);
}

namespace {

Investigation investigate(const Ship& ship, const std::shared_ptr<const EnsembleSimulator>& ensemble,
                          std::vector<Trajectory>& recordings, const GapLocateOptions& options) {
  const auto progress = [&](double done, const std::string& note) {
    if (options.progress) options.progress(done, note);
  };
  Investigation investigation;
  Findings& findings = investigation.findings;
  findings.ship = ship.name;
  findings.L_pp = ship.particulars.L_pp;
  const CampaignOptions campaign_options{options.step_s, 0.0, ensemble};
  prepare(ship, recordings, campaign_options);  // what cannot be used is said before the long work

  progress(0.0, "conventions");
  const auto all_without_frozen = [&] {  // a frozen channel says nothing
    std::vector<Trajectory> moving;
    for (const Trajectory& recording : recordings) moving.push_back(without_frozen(recording));
    return moving;
  };
  std::vector<Trajectory> moving = all_without_frozen();
  std::erase_if(moving, is_at_rest);
  findings.conventions = ensemble ? check_conventions(moving) : check_conventions(ship, moving);
  if (recordings.size() > 1 && !ensemble)
    for (Reading& reading : contradicted_in_one(ship, moving, findings.conventions, options.jobs))
      findings.conventions.contradicted.push_back(std::move(reading));
  progress(0.03, "audit of the sensors");
  AuditOptions audit_options;
  audit_options.false_alarm = options.false_alarm / kTests;
  audit_options.jobs = options.jobs;
  audit_options.seed = options.seed;
  // A contradicted convention would show as faults of every kind; it is read as it fits before.
  std::vector<Trajectory> reread_recordings;
  for (const Trajectory& recording : recordings)
    reread_recordings.push_back(reread(recording, findings.conventions.contradicted));
  findings.audit = audit(reread_recordings, audit_options);
  share_rate(findings.audit);
  std::vector<Fault> certain = findings.audit.faults;
  std::erase_if(certain, [&](const Fault& f) { return is_faint(f, options.false_alarm) && is_early(f); });
  withdraw(findings, certain, "sensors are late, not early");
  findings.corrected =
      options.correct && (!findings.audit.faults.empty() || !findings.conventions.contradicted.empty());
  const auto take_out = [&](const std::vector<Fault>& faults) {
    recordings = reread_recordings;
    for (Trajectory& recording : recordings) recording = corrected(recording, faults);
  };
  if (findings.corrected) take_out(findings.audit.faults);

  Campaign& campaign = investigation.campaign;
  FittedNull& fit = investigation.null;
  FitOptions fit_options;
  fit_options.jobs = options.jobs;
  fit_options.progress = [&](double done, const std::string& note) { progress(0.10 + 0.5 * done, note); };
  const auto fit_anew = [&](const FittedNull* near_by = nullptr) {
    progress(0.10, "fit within the stated uncertainty");
    campaign = prepare(ship, all_without_frozen(), campaign_options);
    fit = fit_null(campaign, fit_options, near_by);
    findings.fit = fit.report;
    if (ensemble) findings.ensemble = use_of(*ensemble, fit);
  };
  const auto examine = [&] {
    progress(0.60, "effects of the catalogue");
    const EffectLibrary library(campaign, fit);
    DetectOptions detect_options;
    detect_options.false_alarm = options.false_alarm;
    detect_options.jobs = options.jobs;
    detect_options.seed = options.seed;
    findings.detection = detect(campaign, fit, library, detect_options);
    findings.detection.untested = untested_of(library, findings.detection);
  };
  fit_anew();
  // A faint fault, taken out where there is none, would look like missing physics.
  std::erase_if(certain, [&](const Fault& f) { return is_faint(f, options.false_alarm) && can_be_compared(f); });
  if (findings.corrected && !ensemble && certain.size() < findings.audit.faults.size()) {
    const auto log_likelihood = [&](const std::vector<Fault>& taken_out) {
      return fit.report.log_likelihood_per_sample * static_cast<double>(fit.report.samples) +
             log_jacobian(taken_out, reread_recordings);
    };
    const double with = log_likelihood(findings.audit.faults);
    take_out(certain);
    fit_anew();
    const double gained = log_likelihood(certain) - with;
    if (gained > kContradicted) {
      withdraw(findings, std::move(certain),
               fmt::format("the simulator then follows the recordings worse (log-odds {:.0f})", gained));
      findings.corrected = !findings.audit.faults.empty() || !findings.conventions.contradicted.empty();
    } else {
      take_out(findings.audit.faults);
      fit_anew();
    }
  }
  // A fault that the kinematics leave open can look like missing physics: taken out, nothing missing is then far
  // likelier, and likelier than any one effect with the fault left in.
  if (const std::vector<Fault> suspects = suspects_of(findings.audit);
      findings.audit.faults.empty() && options.correct && !ensemble && !suspects.empty()) {
    const double as_is = log_evidence(fit);
    double most = std::max(best_evidence(campaign, fit, options) + kContradicted, as_is + kFarLikelier);
    std::optional<Fault> told;
    for (const Fault& suspect : suspects) {
      take_out({suspect});
      Campaign without = prepare(ship, all_without_frozen(), campaign_options);
      const double evidence = log_evidence(fit_null(without, fit_options)) + log_jacobian({suspect}, reread_recordings);
      if (!(evidence > most)) continue;
      most = evidence;
      told = suspect;
    }
    if (told) {
      const auto ways = static_cast<double>(findings.audit.hypotheses.size());
      told->p_value = std::min(told->p_value, ways * std::exp(as_is - most));  // Markov's inequality
      findings.audit.faults.push_back(*told);
      findings.audit.verdict = Audit::Verdict::faulty;
      findings.audit.notices.push_back(
          fmt::format("{}: the kinematics leave it open, but without it the simulator follows the recordings better "
                      "(log-odds {:.0f})",
                      told->name, most - as_is));
      findings.corrected = true;
    }
    take_out(findings.audit.faults);
    if (told) fit_anew();
  }
  if (options.correct && !ensemble &&
      std::any_of(findings.audit.faults.begin(), findings.audit.faults.end(), can_be_compared)) {
    refine(findings.audit.faults, [&](const std::vector<Fault>& faults) {
      take_out(faults);
      Campaign without = prepare(ship, all_without_frozen(), campaign_options);
      return log_evidence(follow(without, fit, {}, options.jobs)) + log_jacobian(faults, reread_recordings);
    });
    take_out(findings.audit.faults);
    const FittedNull near_by = std::move(fit);
    fit_anew(&near_by);
  }
  examine();
  if (findings.detection.p_value < options.false_alarm && !ensemble)
    if (const std::optional<Reading> reading = told_by_fit(campaign, fit, findings.conventions, options)) {
      findings.conventions.contradicted.push_back(*reading);
      if (options.correct) {
        findings.corrected = true;
        for (Trajectory& recording : recordings) recording = reread(recording, {*reading});
        fit_anew();
        examine();
      }
    }

  progress(0.80, "intervals, frames, regimes");
  LocateOptions locate_options;
  locate_options.false_alarm = options.false_alarm;
  locate_options.jobs = options.jobs;
  locate_options.seed = options.seed;
  Location location = locate(campaign, fit, locate_options);
  findings.located = std::move(location.located);
  judge(findings, location.scan_p_value);
  if (findings.verdict == Verdict::no_mismatch) {  // where nothing is, nothing is located
    findings.located.intervals.clear();
    findings.located.regimes.clear();
    findings.located.frames.clear();
    findings.located.modules.clear();
    findings.located.line_of_action.reset();
  }
  findings.residuals = residuals(campaign, fit);
  add_notices(findings, campaign);
  if (ensemble) add_ensemble_notices(*ensemble, findings);
  progress(0.97, "parameters far off");
  return investigation;
}

}  // namespace

}  // namespace leeway::gap
