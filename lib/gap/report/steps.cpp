#include "gap/report/steps.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "effects/description.hpp"
#include "gap/compare/terms.hpp"
#include "gap/report/words.hpp"
#include "gap/show/next_maneuver.hpp"

namespace leeway::gap {

bool changes_ship(const Explanation& explanation) {
  return !explanation.effects.empty() || !explanation.coefficient_factors.empty() ||
         explanation.residual_network != nullptr;
}

namespace {

std::string next_step(const Findings& findings) {
  if (!findings.conventions.contradicted.empty())
    return "correct signs, units and frames first (a columns map, or the recorder's manual), then run again";
  if (!findings.audit.faults.empty() && !findings.corrected) return "repair or correct the sensors, then run again";
  if (findings.grossly_inconsistent && findings.verdict != Verdict::no_mismatch)
    return "check that these are recordings of this ship, at this scale and draft; then gap-explain";
  if (!findings.fit.converged)
    return "the fit has not converged: do not rely on the above; check the ship's particulars and the recordings";
  if (findings.verdict == Verdict::undecided && !findings.located.intervals.empty() &&
      findings.located.intervals.front().is_untrained())
    return "train the ensemble with maneuvers like those of the intervals above; locate.json says which inputs";
  switch (findings.verdict) {
    case Verdict::mismatch:
      return "name what is missing with gap-explain; report.html shows when and where";
    case Verdict::no_mismatch:
      return "nothing is missing on this evidence; gap-explain says whether the ship file's coefficients are right";
    case Verdict::undecided:
      break;
  }
  return "more recordings: other headings, speeds and maneuvers than these";
}

std::string without_slash(std::string folder) {
  while (folder.size() > 1 && folder.ends_with('/')) folder.pop_back();
  return folder;
}

// What names what is missing, with the recordings of this call.
std::string gap_explain_command(const Findings& findings) {
  const Called& called = findings.called;
  if (called.ship.empty() || findings.verdict != Verdict::mismatch || findings.ensemble) return "";
  return fmt::format("gap-explain --ship {} {} -o {}", called.ship, called.recordings,
                     shell_word(without_slash(called.output) + "-explained"));
}

// What to record next.
std::string next_recording(const NextPlan& plan, double p_right) {
  const Recommended best = recommended(plan, p_right);
  const std::string rises =
      fmt::format("the probability of the right name rises from {:.2f} to {:.2f}", p_right, best.p_right);
  switch (best.what) {
    case Recommended::What::maneuver: {
      const NextManeuver& maneuver = plan.maneuvers[best.place];
      return fmt::format("record {} ({:.0f} s): {}", maneuver.name, maneuver.duration_s, rises);
    }
    case Recommended::What::sequence: {
      const NextSequence& both = plan.sequences[best.place];
      const auto [first, second] = both.maneuvers;
      return fmt::format("record {} and {} ({:.0f} s in all): {}; to {:.2f} by the first alone",
                         plan.maneuvers[first].name, plan.maneuvers[second].name, both.duration_s, rises,
                         plan.maneuvers[first].p_right);
    }
    case Recommended::What::record: {
      const NextRecord& record = plan.records[best.place];
      return fmt::format("record {} as well{}{}: {}", record.what, record.maneuver.empty() ? "" : ", in ",
                         record.maneuver, rises);
    }
    case Recommended::What::nothing:
      break;
  }
  if (plan.maneuvers.empty()) return "record elsewhere: no maneuver of the menu can be sailed within the limits";
  return fmt::format(
      "nothing of the menu would tell: no maneuver, no two of them{} (probability of the right name {:.2f} now, {:.2f} "
      "after {})",
      plan.records.empty() ? "" : fmt::format(", not {} either", plan.records.front().what), p_right,
      plan.maneuvers.front().p_right, plan.maneuvers.front().name);
}

// What would have told effects of the surroundings, each once.
std::string to_record(const std::vector<std::string>& names) {
  std::vector<std::string_view> told;
  for (const std::string& name : names)
    if (const std::string_view what = effect_named(name).info.to_record;
        !what.empty() && std::find(told.begin(), told.end(), what) == told.end())
      told.push_back(what);
  return told.empty() ? "" : fmt::format(". In later runs record {}", fmt::join(told, ", and "));
}

// Of effects that were named: what came from outside is apart from what happened to the ship.
std::string advice_on(const std::vector<std::string>& named, const Explanation& explanation) {
  std::vector<std::string> outside;
  std::copy_if(named.begin(), named.end(), std::back_inserter(outside),
               [](const std::string& name) { return find_effect(name) && effect_named(name).info.is_of_surroundings; });
  const bool is_once = std::all_of(named.begin(), named.end(), [](const std::string& name) {
    return find_effect(name) && effect_named(name).info.bound_to == BoundTo::time;
  });
  if (outside.size() == named.size() && is_once)
    return "the ship file can stay: what acted came from outside. Leave that time out, or find out what it was" +
           to_record(outside);
  const bool differs = differ_by_recording(outside, explanation);
  if (outside.size() == named.size())
    return fmt::format("the ship file can stay: what acted came from outside{}{}",
                       explanation.effects.empty() ? ""
                       : differs
                           ? ", and was another one each time: ship-RECORDING.json have it, and ship.json the mean"
                           : ", and ship.json has it for such conditions",
                       to_record(outside));
  if (!explanation.withheld.empty())
    return fmt::format(
        "ask what was different in the held-out recordings: with {} free runs over them err more. Until then {}",
        fmt::join(explanation.withheld, ", "),
        changes_ship(explanation) ? "use ship.json, which is without" : "keep the ship file");
  if (outside.empty()) return "use ship.json as long as the ship is so; with the cause mended, the ship file";
  return "use ship.json as long as the ship is so and where the same comes from outside: it has both. With the cause "
         "mended, or elsewhere, take that effect out of ship.json" +
         to_record(outside);
}

// Whether the fitted coefficients can be used as they are.
bool is_usable_calibration(const Explanation& explanation) {
  return explanation.calibration->helps && explanation.verdict != Verdict::mismatch &&
         explanation.ship_file.state != ShipFileState::cannot_tell;
}

std::string advice_on_calibration(const Explanation& explanation) {
  if (explanation.verdict == Verdict::mismatch)
    return "ask first what else is missing: gap-explain without --calibrate, with the same recordings";
  if (!explanation.calibration->helps)
    return "keep the ship file: with ship.json what was not fitted is not followed better, beyond chance";
  return is_usable_calibration(explanation)
             ? "use ship.json within the speeds, revolutions and rudder angles that were recorded"
             : "record more before ship.json is used: other headings, speeds and maneuvers than these";
}

// What somebody who has read no more than this should do.
std::string advice(const Explanation& explanation) {
  const Findings& findings = explanation.findings;
  if (!findings.conventions.contradicted.empty())
    return "correct signs, units and frames as said above (a columns map, or the recorder's manual), then run again";
  if (!findings.audit.faults.empty())
    return findings.corrected ? "repair the sensor, or correct its recordings as said above, and run again; the ship "
                                "file was compared with them corrected"
                              : "repair or correct the sensors, then run again";
  if (explanation.calibration) return advice_on_calibration(explanation);
  if (!explanation.heldout_is_followed && explanation.chosen.empty())
    return "ask what was different in the held-out recordings, which are not followed: gap-explain with them alone";
  std::vector<std::string> named = explanation.chosen;
  std::erase(named, name_of_terms());
  const bool is_unknown = has_terms(explanation.chosen);
  if (!named.empty() && !is_unknown) return advice_on(named, explanation);
  const bool is_off = explanation.ship_file.state == ShipFileState::off;
  const bool is_better = !fall_of_errors(explanation.heldout).empty();
  if (is_unknown)
    return fmt::format(
        "{}, and do not trust it where this acts. Record "
        "the same maneuvers again, and look there for what the catalogue does not hold",
        changes_ship(explanation) && is_better ? "use ship.json, which errs less, in place of the ship "
                                                 "file"
                                               : "keep the ship file");
  const bool has_cause = std::any_of(explanation.ship_file.findings.begin(), explanation.ship_file.findings.end(),
                                     [](const ShipFileFinding& f) { return !f.cause.empty(); });
  if (is_off && !explanation.coefficient_factors.empty())
    return fmt::format("use ship.json, whose coefficients were fitted, in place of the ship file{}",
                       has_cause ? "; and look at the ship: what is said to do the same would be a cause to mend" : "");
  if (is_off) return "check the coefficients named above in the ship file";
  if (explanation.verdict == Verdict::no_mismatch && explanation.ship_file.state == ShipFileState::as_stated)
    return "use the ship file as it is";
  return "record more before anything is changed: other headings, speeds and maneuvers than these";
}

// That a single recording has nobody to check it.
std::string check_of_one(const Explanation& explanation) {
  const bool is_one = explanation.findings.residuals.size() == 1 && !explanation.heldout_is_given;
  return is_one && (explanation.verdict == Verdict::mismatch || explanation.calibration)
             ? ". First record another run on another heading: one recording alone checks nothing of this"
             : "";
}

// Whether faults of sensors that are not distinguished come first.
bool are_sensors_open(const Explanation& explanation, const Explained* what) {
  return !explanation.findings.audit.faults.empty() && what != nullptr && !what->confusable_with.empty() &&
         !what->separating_maneuver.empty();
}

// What to record next; empty where nothing would tell more.
std::string next_step(const Explanation& explanation, const Explained* what) {
  const Findings& findings = explanation.findings;
  if (!findings.conventions.contradicted.empty()) return "";
  if (!findings.audit.faults.empty() && !findings.corrected) return "";
  if (are_sensors_open(explanation, what)) return "record " + what->separating_maneuver;
  return explanation.next ? next_recording(*explanation.next, explanation.p_right) : "";
}

// ship.json, where it differs from the ship as it was and errs less, in a command that runs as it stands.
std::string use_of_ship(const Explanation& explanation) {
  const Called& called = explanation.findings.called;
  if (called.ship.empty() || !changes_ship(explanation)) return "";
  if (explanation.calibration && !is_usable_calibration(explanation)) return "";
  if (has_terms(explanation.chosen) && fall_of_errors(explanation.heldout).empty()) return "";
  return fmt::format("mmg-sim zigzag --ship {} --rudder-deg 10 --heading-deg 10{} -o zigzag.csv",
                     shell_word(without_slash(called.output) + "/ship.json"),
                     explanation.n_rps ? fmt::format(" --n-p-rps {:.4g}", *explanation.n_rps) : "");
}

// The maneuvers to record, likewise.
std::string plan(const Explanation& explanation) {
  const Called& called = explanation.findings.called;
  if (called.ship.empty() || !explanation.next) return "";
  const NextPlan& plan = *explanation.next;
  const Recommended best = recommended(plan, explanation.p_right);
  const auto command = [&](std::size_t maneuver, std::string_view file) {
    return fmt::format("mmg-sim {} --ship {} -o {}", plan.maneuvers[maneuver].command, called.ship, file);
  };
  if (best.what == Recommended::What::maneuver) return command(best.place, "planned.csv") + "   # what to expect of it";
  if (best.what != Recommended::What::sequence) return "";
  const auto [first, second] = plan.sequences[best.place].maneuvers;
  return fmt::format("{} && {}   # what to expect of them", command(first, "planned-1.csv"),
                     command(second, "planned-2.csv"));
}

}  // namespace

std::vector<Step> steps(const Findings& findings) {
  return {{"Next", next_step(findings), gap_explain_command(findings)}};
}

std::vector<Step> steps(const Explanation& explanation) {
  const Explained* what = chosen_of(explanation);
  const std::string next = next_step(explanation, what);
  return {{"Do", advice(explanation) + check_of_one(explanation), use_of_ship(explanation)},
          {"Next", next, next.empty() || are_sensors_open(explanation, what) ? "" : plan(explanation)}};
}

}  // namespace leeway::gap
